"""Reads tables of measurements from CSV files, and refuses wrong files with a message of one line.

A file has comment lines, a line with the names of the columns, and rows of values.
"""

from __future__ import annotations

import csv
import gzip
import io
import zlib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from tatamu.base.errors import InputError
from tatamu.base.files import read_text


@dataclass(frozen=True)
class Columns:
    """The rows of a table, with all values as text."""

    path: Path
    rows: list[dict[str, str]]

    @classmethod
    def load(cls, path: Path, needed: Sequence[str]) -> Columns:
        """Read a table from a .csv or .csv.gz file.

        The file must have the columns `needed`.

        Raises:
            InputError: If the file cannot be read, has no rows or lacks a column.
        """
        text = _unpacked(path) if path.suffix == ".gz" else read_text(path)
        lines = [line for line in text.splitlines() if line and not line.startswith("#")]
        reader = csv.DictReader(lines)
        missing = [name for name in needed if name not in (reader.fieldnames or ())]
        if missing:
            raise InputError(
                f"{path}: must have the column {missing[0]}, given {', '.join(reader.fieldnames or ())[:80]}"
            )
        rows = list(reader)
        if not rows:
            raise InputError(f"{path}: must hold at least one row, given none")
        return cls(path, rows)

    def number(self, row: int, column: str) -> float:
        """Return the value in a row and a column as a finite number.

        Raises:
            InputError: If the value is not a finite number.
        """
        text = self.rows[row].get(column) or ""
        try:
            value = float(text)
        except ValueError:
            value = np.nan
        if not np.isfinite(value):
            raise InputError(f"{self.path}: row {row + 1}: {column}: must be a finite number, given {text!r}")
        return value


def _unpacked(path: Path) -> str:
    try:
        with gzip.open(path) as file:
            return io.TextIOWrapper(file, encoding="utf-8").read()
    except (EOFError, zlib.error, UnicodeDecodeError, gzip.BadGzipFile) as error:
        raise InputError(f"{path}: cannot be read ({error})") from None
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from None
