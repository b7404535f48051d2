"""The options `--env...` of LeRobot for tatamu's environment, and the features that they make."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import gymnasium
from lerobot.configs import FeatureType, PolicyFeature
from lerobot.envs.configs import EnvConfig
from lerobot.utils.constants import ACTION, OBS_ENV_STATE, OBS_IMAGES, OBS_STATE

GYM_ID = "lerobot_env_tatamu/Hands-v0"


@EnvConfig.register_subclass("tatamu")
@dataclass
class TatamuEnvConfig(EnvConfig):
    """Hands that fold a garment."""

    task: str | None = "Hands-v0"
    fps: int = 10
    garment: str = "towel"
    fold: str = "half"
    width: float | None = None
    length: float | None = None
    material: str | None = None
    spacing: float | None = None
    disturbances: str = "default"
    cameras: list[str] = field(default_factory=lambda: ["top", "front"])
    pixels: int = 96
    seconds: float = 6.0
    features: dict[str, PolicyFeature] = field(default_factory=dict)
    features_map: dict[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Fill in the features from the environment's own spaces."""
        from lerobot_env_tatamu.environment import LeRobotHands

        if (self.width is None) != (self.length is None):
            raise ValueError("width and length: give both, or none")
        spaces: Any = LeRobotHands(**self.gym_kwargs).observation_space
        actions = 4 * (spaces["agent_pos"].shape[0] // 4)
        picture = (self.pixels, self.pixels, 3)
        self.features = {
            ACTION: PolicyFeature(type=FeatureType.ACTION, shape=(actions,)),
            "agent_pos": PolicyFeature(type=FeatureType.STATE, shape=spaces["agent_pos"].shape),
            "environment_state": PolicyFeature(type=FeatureType.ENV, shape=spaces["environment_state"].shape),
            **{f"pixels/{name}": PolicyFeature(type=FeatureType.VISUAL, shape=picture) for name in self.cameras},
        }
        self.features_map = {
            ACTION: ACTION,
            "agent_pos": OBS_STATE,
            "environment_state": OBS_ENV_STATE,
            **{f"pixels/{name}": f"{OBS_IMAGES}.{name}" for name in self.cameras},
        }

    @property
    def package_name(self) -> str:
        """The package that registers the environment."""
        return "lerobot_env_tatamu"

    @property
    def gym_kwargs(self) -> dict[str, Any]:
        """Arguments of `LeRobotHands`."""
        size = None if self.width is None or self.length is None else (self.width, self.length)
        return {
            "garment": self.garment,
            "fold": self.fold,
            "size": size,
            "material": self.material,
            "spacing": self.spacing,
            "disturbances": self.disturbances,
            "cameras": tuple(self.cameras),
            "pixels": self.pixels,
            "rate": self.fps,
            "seconds": self.seconds,
        }


if GYM_ID not in gymnasium.registry:
    gymnasium.register(id=GYM_ID, entry_point="lerobot_env_tatamu.environment:LeRobotHands")
