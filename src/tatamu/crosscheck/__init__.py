"""Cross-check: a learned fold in another simulator, and how far simulators agree at all."""

from tatamu.crosscheck.agreement import Agreement, compare
from tatamu.crosscheck.check import Opinion, check

__all__ = ["Agreement", "Opinion", "check", "compare"]
