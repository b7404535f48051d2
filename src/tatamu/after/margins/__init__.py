"""Margins: how large each disturbance may be before a learned fold fails, and how often the fold succeeds."""

from tatamu.after.margins.measurement import DRAWS, Measured, measure

__all__ = ["DRAWS", "Measured", "measure"]
