"""Margins: how far hands, cloth and table may be off before a learned fold fails, and how often it holds."""

from tatamu.margins.measurement import DRAWS, Measured, measure

__all__ = ["DRAWS", "Measured", "measure"]
