"""Cross-check: a learned fold in another simulator, and the agreement of simulators in general."""

from tatamu.crosscheck.agreement import Agreement, compare
from tatamu.crosscheck.check import Opinion, check

__all__ = ["Agreement", "Opinion", "check", "compare"]
