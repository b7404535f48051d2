"""Cloth folding by tatamu as an environment of LeRobot: `--env.type=tatamu`.

LeRobot imports this package by its name, and with it the configuration that it registers.
"""

from lerobot_env_tatamu.config import TatamuEnvConfig
from lerobot_env_tatamu.environment import LeRobotHands

__all__ = ["LeRobotHands", "TatamuEnvConfig"]
