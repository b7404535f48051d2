"""Two Gymnasium environments: `Fold-v0` makes a fold in one action, and in `Hands-v0` a policy moves the hands.

For example::

    env = gymnasium.make("tatamu.envs:tatamu/Hands-v0", garment="towel", observation="key_points")
"""

from __future__ import annotations

from tatamu.base.extras import lacking

try:
    import gymnasium
except ImportError:
    raise lacking("gymnasium", "gym", "environments") from None

from tatamu.policies.envs.cameras import CAMERAS
from tatamu.policies.envs.fold import FoldEnv
from tatamu.policies.envs.hands import HandsEnv
from tatamu.policies.envs.observation import OBSERVATIONS
from tatamu.policies.envs.threads import ThreadedVectorEnv

FOLD = "tatamu/Fold-v0"
HANDS = "tatamu/Hands-v0"


for name, entry, vector in (  # so that `gymnasium.make` and `gymnasium.make_vec` find both environments
    (FOLD, "tatamu.policies.envs.fold:FoldEnv", "tatamu.policies.envs.threads:vector_of_folds"),
    (HANDS, "tatamu.policies.envs.hands:HandsEnv", "tatamu.policies.envs.threads:vector_of_hands"),
):
    if name not in gymnasium.registry:
        gymnasium.register(id=name, entry_point=entry, vector_entry_point=vector)
del name, entry, vector

__all__ = ["CAMERAS", "FOLD", "HANDS", "OBSERVATIONS", "FoldEnv", "HandsEnv", "ThreadedVectorEnv"]
