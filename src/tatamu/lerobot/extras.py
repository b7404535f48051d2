"""Optional packages of datasets; one that is missing is reported in one line, with how to install it."""

from __future__ import annotations

from functools import partial

from tatamu import extras

needed = partial(extras.needed, extra="dataset")
"""Function that imports a package which the extra `dataset` installs."""
