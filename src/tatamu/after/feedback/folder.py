"""The files of observed folds in the folder of a learned fold: `observed/N.json`, `posterior.toml`, `corrected-N`.

docs/reference/observation.md describes these files. A folder `corrected-N` contains the fold with the correction after
N observed folds. It has the form of the folder of a learned fold. Its subfolder `observed/` contains the observations
of folds that were carried out with this correction.
"""

from __future__ import annotations

from dataclasses import dataclass
from hashlib import sha256
from pathlib import Path

import tomli_w

from tatamu.after.feedback.measured import Observation
from tatamu.after.margins.measurement import KEPT
from tatamu.base.errors import InputError
from tatamu.base.files import read_text, write_json, write_text
from tatamu.base.version import __version__ as VERSION
from tatamu.evaluation.disturbances import Disturbances
from tatamu.study.folder import ResultFolder

OBSERVED = "observed"
POSTERIOR = "posterior.toml"
CORRECTED = "corrected-"
HEAD = (
    "# Disturbances of one set-up, given its observed folds. docs/reference/disturbances.md explains the fields.\n"
    "# Take it with --disturbances, or with --after together with the fold.\n\n"
)


@dataclass(frozen=True)
class ObservedFolder:
    """A folder on disk with the files of a learned fold and of its observations.

    An observation describes how the cloth ended when a robot carried out the learned fold.
    """

    path: Path

    @classmethod
    def of(cls, path: Path) -> ObservedFolder:
        """Return the folder of a learned fold.

        The argument is this folder, or the folder of a corrected fold inside it.
        """
        inner = path.resolve()
        if not inner.name.startswith(CORRECTED):
            return cls(path)
        return cls(path.parent if path.name == inner.name else inner.parent)  # ".", as a relative path, has no parent

    @property
    def posterior_file(self) -> Path:
        """Path of the file with the distribution of the errors after observed folds, `posterior.toml`."""
        return self.path / POSTERIOR

    @property
    def page_file(self) -> Path:
        """Path of the page `observed/observation.html`."""
        return self.path / OBSERVED / "observation.html"

    @property
    def correction_file(self) -> Path:
        """Path of the file with the next correction, `observed/correction.json`."""
        return self.path / OBSERVED / "correction.json"

    @property
    def digest(self) -> str:
        """A digest of all that determines the next correction: the fold, its observations and the inferred errors."""
        files = [file for variant in self.variants() for file in self.files(variant)]
        digest = sha256(VERSION.encode())
        for file in (self.path / "result.json", self.posterior_file, *files):
            digest.update(f"{file.relative_to(self.path)} {read_text(file) if file.exists() else ''}".encode())
        return digest.hexdigest()

    @property
    def has_draws(self) -> bool:
        """Whether the folder has simulations by `tatamu margins` or `tatamu observe`."""
        return (ResultFolder(self.path).margins_folder / KEPT).exists()

    def corrected(self, number: int) -> Path:
        """Return the folder of the fold with the correction after `number` observed folds."""
        return self.path / f"{CORRECTED}{number}"

    def variants(self) -> list[Path]:
        """Return the folders of all variants of a fold: the learned fold first, then the corrected folds."""
        numbered = [path for path in self.path.glob(f"{CORRECTED}*") if path.name.removeprefix(CORRECTED).isdecimal()]
        return [self.path, *sorted(numbered, key=lambda path: int(path.name.removeprefix(CORRECTED)))]

    @staticmethod
    def files(variant: Path) -> list[Path]:
        """Return the files with the observations of one variant (the learned fold or a corrected fold), in order."""
        found = [path for path in (variant / OBSERVED).glob("*.json") if path.stem.isdecimal()]
        return sorted(found, key=lambda path: int(path.stem))

    def observations(self) -> list[tuple[Path, Observation]]:
        """Return all observations, each with the folder of the learned or corrected fold that was carried out.

        Raises:
            InputError: If a file cannot be read, or a field is wrong. The message names the file and the field.
        """
        return [(variant, Observation.load(file)) for variant in self.variants() for file in self.files(variant)]

    def place_of_next(self, variant: Path) -> int:
        """Return the index among all observations that the next observation of a variant will have.

        A variant is the learned fold or a corrected fold.
        """
        known = [each.resolve() for each in self.variants()]
        until = known.index(variant.resolve()) + 1 if variant.resolve() in known else len(known)
        return sum(len(self.files(each)) for each in known[:until])

    def photos(self) -> list[Path]:
        """Return a path for each observation. If the observation has a photograph, its file is at this path."""
        return [file.with_suffix(".jpg") for variant in self.variants() for file in self.files(variant)]

    @classmethod
    def add(cls, variant: Path, observation: Observation) -> Path:
        """Write an observation into the folder of the learned or corrected fold `variant`, and return its file."""
        number = max((int(file.stem) for file in cls.files(variant)), default=0) + 1
        path = variant / OBSERVED / f"{number}.json"
        write_json(path, observation.model_dump())
        return path

    def write_posterior(self, posterior: Disturbances) -> None:
        """Write `posterior.toml`, the distribution of the errors after the observed folds."""
        plain = posterior.describe()
        if not plain:
            raise InputError(f"{self.posterior_file}: there is nothing uncertain to write")
        write_text(self.posterior_file, HEAD + tomli_w.dumps(plain))
