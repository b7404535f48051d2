"""Cross-checks: simulates a learned fold in another simulator, and compares simulators over several folds."""

from tatamu.after.second_opinion.agreement import Agreement, compare
from tatamu.after.second_opinion.check import Opinion, check

__all__ = ["Agreement", "Opinion", "check", "compare"]
