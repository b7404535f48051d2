"""Optional packages of datasets. If a package is missing, one line reports it with the command to install it."""

from __future__ import annotations

from functools import partial

from tatamu.base import extras

needed = partial(extras.needed, extra="dataset")
"""Function that imports a package. The extra `dataset` installs the package."""
