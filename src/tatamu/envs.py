"""The environments under the name by which Gymnasium finds them: `gymnasium.make("tatamu.envs:tatamu/Fold-v0")`."""

from tatamu.policies.envs import *  # noqa: F403
from tatamu.policies.envs import __all__ as __all__
