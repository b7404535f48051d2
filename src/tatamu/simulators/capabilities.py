"""The abilities and limits of a simulator, stated by itself, so that callers ask instead of knowing names."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class Capabilities:
    """The abilities and limits of a simulator; the defaults are the usual case."""

    parallel: bool = False
    """Whether `simulate` may be called in several threads of one process at a time, and then gives the same positions
    whatever runs beside it."""
    coarse_search: bool = False
    """Whether folds on a coarser mesh are ranked nearly as on the default one, so that a search may begin there."""
    compression: bool = False
    """Whether cloth may resist compression less than tension (`Material.compression`); else it resists both alike."""
    sound_cell: float | None = None
    """Mean edge of the largest cells, in bending lengths, whose folds have the right shape; None: not limited."""
    usable_cell: float | None = None
    """Mean edge of the largest cells, in bending lengths, on which two folds may be compared with one another, though
    neither has quite the right shape. None: not limited."""
    friction_table: float | None = None
    """Largest Coulomb coefficient between cloth and table; larger ones are cut to it. None: not limited."""
    friction_cloth: float | None = None
    """Largest Coulomb coefficient between layers of cloth; larger ones are cut to it. None: not limited."""
