"""tatamu learns in simulation how a dual-arm robot folds cloth."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tatamu.errors import InputError, SimulationError, TatamuError
    from tatamu.material import Material
    from tatamu.rollout import Rollout
    from tatamu.scene import Cloth, Gripper, Scene, Table
    from tatamu.simulators import simulate, simulate_many

__version__ = "0.1.0"

_HOME = {
    "Cloth": "tatamu.scene",
    "Gripper": "tatamu.scene",
    "InputError": "tatamu.errors",
    "Material": "tatamu.material",
    "Rollout": "tatamu.rollout",
    "Scene": "tatamu.scene",
    "SimulationError": "tatamu.errors",
    "Table": "tatamu.scene",
    "TatamuError": "tatamu.errors",
    "simulate": "tatamu.simulators",
    "simulate_many": "tatamu.simulators",
}

__all__ = [
    "Cloth",
    "Gripper",
    "InputError",
    "Material",
    "Rollout",
    "Scene",
    "SimulationError",
    "Table",
    "TatamuError",
    "simulate",
    "simulate_many",
]


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used, so that `import tatamu` stays quick."""
    if name not in _HOME:
        raise AttributeError(f"module 'tatamu' has no attribute {name!r}")
    return getattr(import_module(_HOME[name]), name)
