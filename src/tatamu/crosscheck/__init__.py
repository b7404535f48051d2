"""Cross-check: a learned fold is simulated in another simulator, and simulators are compared in general."""

from tatamu.crosscheck.agreement import Agreement, compare
from tatamu.crosscheck.check import Opinion, check

__all__ = ["Agreement", "Opinion", "check", "compare"]
