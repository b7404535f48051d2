"""tatamu learns in simulation how a dual-arm robot folds cloth.

import tatamu as tt

task = tt.make_task("towel", size=(0.34, 0.80), fold="half")
result = tt.learn(task, tt.LearnOptions(trials=50, seed=0), progress=print)
result.write_report("towel.html")
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from tatamu.api import (
        PlanResult,
        Result,
        calibrate,
        check,
        correct,
        learn,
        load,
        measure_margins,
        observe,
        plan_for,
    )
    from tatamu.base.errors import InputError, SimulationError, TatamuError, UnavailableError
    from tatamu.cameras.locate import locate
    from tatamu.evaluation.coarse import CoarseFirst
    from tatamu.evaluation.disturbances.description import Disturbances, load_disturbances
    from tatamu.evaluation.disturbed import Disturbed
    from tatamu.evaluation.evaluator import Evaluation, Evaluator, Wrapper
    from tatamu.evaluation.nominal import Nominal
    from tatamu.evaluation.reach import WithinReach
    from tatamu.folding.manipulation import Manipulation
    from tatamu.folding.score import Limits, Score
    from tatamu.folding.task import Task, make_task
    from tatamu.garments import make_garment, register_garment
    from tatamu.garments.garment import Garment
    from tatamu.policies.dataset import make_dataset, replay
    from tatamu.robots.constraint import find_reach
    from tatamu.search.gp import GPSearch
    from tatamu.search.registry import register_search
    from tatamu.search.search import Search
    from tatamu.search.space import Bounds, Space
    from tatamu.search.two_fidelity import TwoFidelitySearch
    from tatamu.simulation.material import Material
    from tatamu.simulation.native import BodyTarget, HandTarget, Simulation, SimulationState
    from tatamu.simulation.rollout import Rollout
    from tatamu.simulation.scene import Cloth, Gripper, Scene, Table
    from tatamu.simulation.simulators import register_simulator, simulate, simulate_many
    from tatamu.study.loop import Progress
    from tatamu.study.options import LearnOptions
    from tatamu.study.trial import Trial

from tatamu.base.moved import install as _install
from tatamu.base.version import __version__ as __version__

_install()

_HOME = {
    "BodyTarget": "tatamu.simulation.native",
    "Bounds": "tatamu.search.space",
    "Cloth": "tatamu.simulation.scene",
    "CoarseFirst": "tatamu.evaluation.coarse",
    "Disturbances": "tatamu.evaluation.disturbances.description",
    "Disturbed": "tatamu.evaluation.disturbed",
    "Evaluation": "tatamu.evaluation.evaluator",
    "Evaluator": "tatamu.evaluation.evaluator",
    "GPSearch": "tatamu.search.gp",
    "Garment": "tatamu.garments.garment",
    "Gripper": "tatamu.simulation.scene",
    "HandTarget": "tatamu.simulation.native",
    "InputError": "tatamu.base.errors",
    "LearnOptions": "tatamu.study.options",
    "Limits": "tatamu.folding.score",
    "Manipulation": "tatamu.folding.manipulation",
    "Material": "tatamu.simulation.material",
    "Nominal": "tatamu.evaluation.nominal",
    "PlanResult": "tatamu.api",
    "Progress": "tatamu.study.loop",
    "Result": "tatamu.api",
    "Rollout": "tatamu.simulation.rollout",
    "Scene": "tatamu.simulation.scene",
    "Score": "tatamu.folding.score",
    "Search": "tatamu.search.search",
    "Simulation": "tatamu.simulation.native",
    "SimulationError": "tatamu.base.errors",
    "SimulationState": "tatamu.simulation.native",
    "Space": "tatamu.search.space",
    "Table": "tatamu.simulation.scene",
    "Task": "tatamu.folding.task",
    "TatamuError": "tatamu.base.errors",
    "Trial": "tatamu.study.trial",
    "TwoFidelitySearch": "tatamu.search.two_fidelity",
    "UnavailableError": "tatamu.base.errors",
    "WithinReach": "tatamu.evaluation.reach",
    "Wrapper": "tatamu.evaluation.evaluator",
    "calibrate": "tatamu.api",
    "check": "tatamu.api",
    "correct": "tatamu.api",
    "find_reach": "tatamu.robots.constraint",
    "learn": "tatamu.api",
    "load": "tatamu.api",
    "load_disturbances": "tatamu.evaluation.disturbances.description",
    "locate": "tatamu.cameras.locate",
    "make_dataset": "tatamu.policies.dataset",
    "make_garment": "tatamu.garments",
    "make_task": "tatamu.folding.task",
    "measure_margins": "tatamu.api",
    "observe": "tatamu.api",
    "plan_for": "tatamu.api",
    "register_garment": "tatamu.garments",
    "register_search": "tatamu.search.registry",
    "register_simulator": "tatamu.simulation.simulators",
    "replay": "tatamu.policies.dataset",
    "simulate": "tatamu.simulation.simulators",
    "simulate_many": "tatamu.simulation.simulators",
}

__all__ = [
    "BodyTarget",
    "Bounds",
    "Cloth",
    "CoarseFirst",
    "Disturbances",
    "Disturbed",
    "Evaluation",
    "Evaluator",
    "GPSearch",
    "Garment",
    "Gripper",
    "HandTarget",
    "InputError",
    "LearnOptions",
    "Limits",
    "Manipulation",
    "Material",
    "Nominal",
    "PlanResult",
    "Progress",
    "Result",
    "Rollout",
    "Scene",
    "Score",
    "Search",
    "Simulation",
    "SimulationError",
    "SimulationState",
    "Space",
    "Table",
    "Task",
    "TatamuError",
    "Trial",
    "TwoFidelitySearch",
    "UnavailableError",
    "WithinReach",
    "Wrapper",
    "calibrate",
    "check",
    "correct",
    "find_reach",
    "learn",
    "load",
    "load_disturbances",
    "locate",
    "make_dataset",
    "make_garment",
    "make_task",
    "measure_margins",
    "observe",
    "plan_for",
    "register_garment",
    "register_search",
    "register_simulator",
    "replay",
    "simulate",
    "simulate_many",
]


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used, so that `import tatamu` is quick."""
    if name not in _HOME:
        raise AttributeError(f"module 'tatamu' has no attribute {name!r}")
    try:
        return getattr(import_module(_HOME[name]), name)
    except ModuleNotFoundError as error:
        from tatamu.base.extras import missing

        refused = missing(error)
        if refused is None:
            raise
        raise refused from None


def __dir__() -> list[str]:
    """List the public names."""
    return [*__all__, "__version__"]
