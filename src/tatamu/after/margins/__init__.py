"""Margins: how large each disturbance may be before a learned fold fails, and how often the fold succeeds.

A draw is one random value of each disturbance. A world is the situation that a draw gives. The nominal world has no
disturbances.
"""

from tatamu.after.margins.measurement import DRAWS, Measured, measure

__all__ = ["DRAWS", "Measured", "measure"]
