"""The file of disturbances: possible errors of hands, grasps, cloth, table and material in a simulation.

Numbers are standard deviations. Every field is explained in docs/reference/disturbances.md.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Self

import numpy as np
from pydantic import BeforeValidator, Field, model_validator

from tatamu.base.arrays import is_finite_number
from tatamu.base.errors import InputError
from tatamu.base.files import read_toml, validated
from tatamu.base.records import Record
from tatamu.evaluation.disturbances.channels import CHANNELS, FIELDS, PLACES, prefix_in
from tatamu.folding.fingers import Fingers
from tatamu.simulation.material import Material, Number

OWN = Path(__file__).parent
"""Folder of `default.toml`."""

Length = Annotated[Number, Field(ge=0.0, le=0.5)]
"""Standard deviation of a position [m]."""
Angle = Annotated[Number, Field(ge=0.0, le=1.0)]
"""Standard deviation of an angle [rad]."""
Time = Annotated[Number, Field(ge=0.0, le=2.0)]
"""Standard deviation of a time [s]."""
MAX_RELATIVE = 2.0
"""Maximum standard deviation of the logarithm of a factor: a factor of seven."""
Relative = Annotated[Number, Field(ge=0.0, le=MAX_RELATIVE)]
"""Standard deviation of the logarithm of a factor."""
ThreeLengths = Annotated[list[Length], Field(min_length=3, max_length=3)]
"""Standard deviations along the fold, across it, and up [m]."""
TwoLengths = Annotated[list[Length], Field(min_length=2, max_length=2)]
"""Standard deviations along the fold and across it [m]."""
Share = Annotated[Number, Field(ge=0.0, le=1.0)]


def _flat(value: Any) -> Any:
    """Return nested tables as one, with names joined by dots, such as "hands.offset.along"."""
    if not isinstance(value, Mapping):
        return value
    found: dict[str, Any] = {}
    for name, inner in value.items():
        part = _flat(inner)
        if isinstance(part, dict):
            found |= {f"{name}.{rest}": number for rest, number in part.items()}
        else:
            found[str(name)] = part
    return found


def _one_or_two(value: Any) -> Any:
    """Check one standard deviation for both hands, or one for each."""
    each = value if isinstance(value, list) and len(value) == 2 else [value]
    if any(isinstance(one, bool) or not isinstance(one, int | float) or not 0.0 <= one <= 0.5 for one in each):
        raise ValueError(f"must be a number from 0 to 0.5, or one number for each hand [left, right], given {value!r}")
    return value


LengthOfHands = Annotated[float | list[float], BeforeValidator(_one_or_two)]
"""Standard deviation of a position [m]: for both hands, or for the left and for the right hand."""


class HandErrors(Record):
    """Standard deviations of the errors of the hands, which stay constant during one fold."""

    offset: ThreeLengths = Field(default_factory=lambda: [0.0] * 3)
    """Common offset of both hands along the fold, across it, and up [m]."""
    difference: ThreeLengths = Field(default_factory=lambda: [0.0] * 3)
    """Error of the left hand's position relative to the right hand, along the fold, across it, and up [m]; half of it
    acts on each."""
    yaw: Angle = 0.0
    """Rotation of both hands about the middle between them [rad]."""
    opening_delay: Time = 0.0
    """Delay between the openings of the hands [s]."""
    speed: Relative = 0.0
    """Relative deviation of the speed of both hands."""


class GraspErrors(Record):
    """Standard deviations of the errors of the grasps, independent for each hand.

    They do not change the place where the hands lay the cloth down.
    """

    along: LengthOfHands = 0.0
    """Error of a grasp along the edge of the cloth [m]."""
    into: LengthOfHands = 0.0
    """Error of a grasp towards the inside of the cloth [m]."""


class PlaceErrors(Record):
    """Standard deviations of the errors of the assumed position of the cloth."""

    place: TwoLengths = Field(default_factory=lambda: [0.0] * 2)
    """Displacement along the fold and across it [m]."""
    yaw: Angle = 0.0
    """Rotation about the middle of the cloth [rad]."""


class TableErrors(Record):
    """Standard deviations of the errors of the table."""

    height: Length = 0.0
    """Error in the height of the table's top [m]."""


class Correlation(Record):
    """Correlations between disturbances, of the logarithms for fields of the material, as in a calibrated material."""

    parameters: list[str]
    matrix: list[list[Annotated[Number, Field(ge=-1.0, le=1.0)]]]

    @model_validator(mode="after")
    def _check(self) -> Self:
        count = len(self.parameters)
        if unknown := [name for name in self.parameters if name not in FIELDS and name not in PLACES]:
            raise ValueError(
                f"parameters must be names of disturbances or of material fields ({', '.join(FIELDS)}), given "
                f"{unknown[0]!r}"
            )
        if len(set(self.parameters)) < count:
            raise ValueError(f"parameters must not contain the same name twice, given {', '.join(self.parameters)}")
        if [len(row) for row in self.matrix] != [count] * count:
            raise ValueError(f"matrix must have {count} rows of {count} numbers, one for each parameter")
        matrix = np.array(self.matrix).reshape(count, count)
        if count and (np.abs(matrix - matrix.T).max() > 1e-6 or np.abs(np.diag(matrix) - 1.0).max() > 1e-6):
            raise ValueError("matrix must be symmetric with ones on its diagonal")
        if count and np.linalg.eigvalsh(matrix)[0] < -0.01:  # entries rounded to three digits cause small negative ones
            raise ValueError("matrix must have eigenvalues of at least 0, like every correlation matrix")
        return self


class Disturbances(Record):
    """Uncertainties of hands, cloth and table. A quantity without an entry is exact."""

    hands: HandErrors = HandErrors()
    grasp: GraspErrors = GraspErrors()
    cloth: PlaceErrors = PlaceErrors()
    table: TableErrors = TableErrors()
    material: dict[str, Relative] = Field(default_factory=dict)
    """Relative deviations of the material, by the names of its fields."""
    correlation: Correlation | None = None
    """Correlations by fields of `material`, or by `CHANNELS`; None if all disturbances are independent."""
    mean: Annotated[dict[str, Number], BeforeValidator(_flat)] = Field(default_factory=dict)
    """Means that are not zero, by `CHANNELS`; of logarithms for relative disturbances."""
    systematic: Annotated[dict[str, Share], BeforeValidator(_flat)] = Field(default_factory=dict)
    """Fraction of each variance that is equal in every fold of a set-up (one robot, garment and table), by `CHANNELS`
    or their beginnings. The file `systematic.toml` contains the defaults."""
    fingers: Fingers = Fingers()
    """Fingers of the hands, which are not disturbed."""

    @model_validator(mode="after")
    def _check(self) -> Self:
        if unknown := [name for name in self.material if name not in FIELDS]:
            raise ValueError(f"material.{unknown[0]} must be one of {', '.join(FIELDS)}")
        given = self.correlation.parameters if self.correlation else []
        if missing := [name for name in given if name in FIELDS and name not in self.material]:
            raise ValueError(
                f"correlation.parameters contains {missing[0]}, but [material] does not; add {missing[0]} to [material]"
            )
        for name, value in self.mean.items():
            if name not in PLACES:
                raise ValueError(f"mean.{name} must be the name of a disturbance, such as hands.offset.along")
            most = {"m": 0.5, "rad": 1.0, "s": 2.0, "1": MAX_RELATIVE}[CHANNELS[PLACES[name]].unit]
            if abs(value) > most:
                raise ValueError(f"mean.{name} must be from -{most:g} to {most:g}, given {value:g}")
        for name in self.systematic:
            if not any(prefix_in(channel.name, (name,)) for channel in CHANNELS):
                raise ValueError(
                    f"systematic.{name} must be the name of a disturbance, or of a group of disturbances such as "
                    "hands.offset"
                )
        return self

    def describe(self) -> dict[str, Any]:
        """Return plain data for `result.json` and `margins.json`, without defaults."""
        return self.model_dump(exclude_defaults=True)


def load_disturbances(name: str) -> Disturbances | None:
    """Return the disturbances of `default`, `none` or a TOML file. Errors name the file and the field."""
    if name == "none":
        return None
    if name != "default" and not name.endswith(".toml"):
        raise InputError(f"disturbances: must be default, none or a .toml file, given {name!r}")
    return default_disturbances() if name == "default" else read_disturbances(Path(name))


def require_disturbances(name: str) -> Disturbances:
    """Return the disturbances of a file, or the default disturbances.

    Raises:
        InputError: If there are none, the file cannot be read, or a field is wrong.
    """
    found = load_disturbances(name)
    if found is None:
        raise InputError("disturbances: must be default or a .toml file, given 'none'")
    return found


def default_disturbances() -> Disturbances:
    """Return the disturbances that are used if the user gives none."""
    return read_disturbances(OWN / "default.toml")


def read_disturbances(path: Path) -> Disturbances:
    """Return the disturbances of a file. Errors name the file and the field."""
    return disturbances_in(read_toml(path), path)


def disturbances_in(value: Mapping[str, Any], source: Path | str) -> Disturbances:
    """Return disturbances from the tables of a file, of which [source] is ignored. Errors name field and source."""
    return validated(Disturbances, {name: table for name, table in value.items() if name != "source"}, source)


def with_calibrated(disturbances: Disturbances, path: Path, material: Material) -> Disturbances:
    """Return disturbances with the uncertainties of a calibrated material, which is read from `path`.

    Raises:
        InputError: If the table [uncertainty] or [correlation] of the file is wrong.
    """
    value = read_toml(path) if path.is_file() else {}
    uncertainty = value.get("uncertainty")
    if uncertainty is None:
        return disturbances
    if not isinstance(uncertainty, dict):
        raise InputError(f"{path}: uncertainty: must be a table, given {uncertainty!r}")
    relative = {name: _relative(path, name, given, material) for name, given in uncertainty.items()}
    own = {name: deviation for name, deviation in disturbances.material.items() if name not in relative}
    plain = disturbances.model_dump()
    plain["material"] = {**own, **relative}
    plain["correlation"] = value.get("correlation")
    return validated(Disturbances, plain, path)


def _relative(path: Path, name: str, given: Any, material: Material) -> float:
    """Return a standard uncertainty divided by the value of its field [-], but at most `MAX_RELATIVE`."""
    if name not in FIELDS:
        raise InputError(f"{path}: uncertainty.{name}: must be one of {', '.join(FIELDS)}")
    if not is_finite_number(given) or not given >= 0.0:
        raise InputError(f"{path}: uncertainty.{name}: must be a number of 0 or more, given {given!r}")
    value = getattr(material, name)
    if value is None:
        raise InputError(f"{path}: uncertainty.{name}: must be left out, because the material has no {name}")
    return min(float(given) / value, MAX_RELATIVE) if value else 0.0
