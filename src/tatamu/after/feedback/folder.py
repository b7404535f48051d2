"""The files of measured folds in the folder of a learned fold: `observed/N.json`, `posterior.toml`, `corrected-N`.

docs/reference/observation.md describes them. A folder `corrected-N` has the fold with the correction after N measured
folds, and a folder `observed` of its own for the folds that were carried out with this correction.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import tomli_w

from tatamu.after.feedback.correction import Correction
from tatamu.after.feedback.measured import MeasuredFold
from tatamu.after.margins.measurement import KEPT
from tatamu.base.errors import InputError
from tatamu.base.files import in_shell, write_json, write_text
from tatamu.evaluation.disturbances import Disturbances
from tatamu.study.folder import LEARNED, RESULT, ResultFolder
from tatamu.study.result import Result

OBSERVED = "observed"
CORRECTED = "corrected-"
CORRECTION = "correction.json"
HEAD = (
    "# Disturbances of one set-up, given its measured folds. docs/reference/disturbances.md explains the fields.\n"
    "# Use this file with --disturbances, or use --after, which also starts from the learned fold.\n\n"
)


@dataclass(frozen=True)
class FeedbackFolder:
    """The folder of a learned fold, with the files of its measured folds."""

    path: Path

    @classmethod
    def of(cls, path: Path) -> FeedbackFolder:
        """Return the folder of a learned fold, given this folder or that of a corrected fold inside it."""
        inner = path.resolve()
        if not inner.name.startswith(CORRECTED):
            return cls(path)
        return cls(path.parent if path.name == inner.name else inner.parent)  # ".", as a relative path, has no parent

    @property
    def posterior_file(self) -> Path:
        """Path of `posterior.toml`."""
        return self.path / "posterior.toml"

    @property
    def page_file(self) -> Path:
        """Path of the page `observed/observation.html`."""
        return self.path / OBSERVED / "observation.html"

    def variants(self) -> list[Path]:
        """Return the folders of the learned fold and of the corrected folds, in this order."""
        indexed = [path for path in self.path.glob(f"{CORRECTED}*") if path.name.removeprefix(CORRECTED).isdecimal()]
        return [self.path, *sorted(indexed, key=lambda path: int(path.name.removeprefix(CORRECTED)))]

    def files(self) -> list[Path]:
        """Return the files `N.json` of all variants, in order."""
        return [file for variant in self.variants() for file in self._files(variant)]

    def require_measured(self, fold: Path) -> None:
        """Raise an InputError that names the folder of a fold if no variant was measured."""
        if not self.files():
            command = f"tatamu observe {in_shell(fold)} --left A,B --right A,B"
            raise InputError(f"{fold}: contains no measured fold; run `{command}` first")

    @staticmethod
    def _files(variant: Path) -> list[Path]:
        found = [path for path in (variant / OBSERVED).glob("*.json") if path.stem.isdecimal()]
        return sorted(found, key=lambda path: int(path.stem))

    def measured(self) -> list[tuple[Path, MeasuredFold]]:
        """Return all measured folds, each with the folder of the fold that was carried out."""
        return [(file.parent.parent, MeasuredFold.load(file)) for file in self.files()]

    def next_file(self, variant: Path) -> Path:
        """Return the file of the next measured fold of a variant."""
        return variant / OBSERVED / f"{max((int(file.stem) for file in self._files(variant)), default=0) + 1}.json"

    def index_of(self, file: Path) -> int:
        """Return the index of a file of `next_file` among all measured folds."""
        variants = [each.resolve() for each in self.variants()]
        own = file.parent.parent.resolve()
        until = variants.index(own) + 1 if own in variants else len(variants)
        return sum(len(self._files(each)) for each in variants[:until])

    @property
    def has_draws(self) -> bool:
        """Whether simulated scenarios are kept."""
        return (ResultFolder(self.path).margins_folder / KEPT).exists()

    def corrected(self, count: int) -> Path:
        """Return the folder of the fold with the correction after `count` measured folds."""
        return self.path / f"{CORRECTED}{count}"

    def write_posterior(self, posterior: Disturbances) -> None:
        """Write `posterior.toml`."""
        plain = posterior.describe()
        if not plain:
            raise InputError(
                f"{self.posterior_file}: must have at least one standard deviation above 0, given only zeros"
            )
        write_text(self.posterior_file, HEAD + tomli_w.dumps(plain))


def write_corrected(made: Result, correction: Correction, path: Path) -> None:
    """Write the folder of a corrected fold, from which robot plans are made.

    Files of an earlier correction are removed first, so that an interrupted call leaves no mixture.

    Raises:
        InputError: If the folder has another fold, or cannot be written.
    """
    if (path / RESULT).exists() and not (path / CORRECTION).exists():
        raise InputError(
            f"{path}: must be a new folder or the folder of a corrected fold, but contains a learned fold; "
            "give another folder"
        )
    write_json(path / CORRECTION, correction.describe())
    for name in LEARNED:
        (path / name).unlink(missing_ok=True)
    made.save(path)
