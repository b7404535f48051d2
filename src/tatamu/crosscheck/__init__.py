"""Cross-checks: simulates a learned fold in another simulator, and compares simulators over several folds."""

from tatamu.crosscheck.agreement import Agreement, compare
from tatamu.crosscheck.check import Opinion, check

__all__ = ["Agreement", "Opinion", "check", "compare"]
