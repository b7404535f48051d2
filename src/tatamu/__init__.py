"""tatamu learns in simulation how a dual-arm robot folds cloth.

import tatamu as tt

task = tt.make_task("towel", size=(0.34, 0.80), fold="half")
result = tt.learn(task, tt.LearnOptions(trials=50, seed=0), progress=print)
result.write_report("towel.html")
"""

from __future__ import annotations

import ast
from importlib import import_module
from pathlib import Path
from typing import TYPE_CHECKING, Any

from tatamu.base.moved import install as _install
from tatamu.base.version import __version__ as __version__

if TYPE_CHECKING:  # the one list of public names, for type checkers; when one is used, it is imported from there
    from tatamu.api import calibrate as calibrate
    from tatamu.api import check as check
    from tatamu.api import correct as correct
    from tatamu.api import learn as learn
    from tatamu.api import load as load
    from tatamu.api import measure_margins as measure_margins
    from tatamu.api import observe as observe
    from tatamu.api import plan_for as plan_for
    from tatamu.base.errors import InputError as InputError
    from tatamu.base.errors import SimulationError as SimulationError
    from tatamu.base.errors import TatamuError as TatamuError
    from tatamu.base.errors import UnavailableError as UnavailableError
    from tatamu.cameras.locate import locate as locate
    from tatamu.evaluation.disturbances.description import Disturbances as Disturbances
    from tatamu.evaluation.disturbances.description import load_disturbances as load_disturbances
    from tatamu.evaluation.evaluator import Ask as Ask
    from tatamu.evaluation.evaluator import Evaluation as Evaluation
    from tatamu.evaluation.evaluator import Evaluator as Evaluator
    from tatamu.evaluation.evaluator import Wrapper as Wrapper
    from tatamu.evaluation.nominal import Nominal as Nominal
    from tatamu.evaluation.scenarios import Scenarios as Scenarios
    from tatamu.folding.aim import Aim as Aim
    from tatamu.folding.manipulation import Manipulation as Manipulation
    from tatamu.folding.score import Limits as Limits
    from tatamu.folding.score import Score as Score
    from tatamu.folding.task import Task as Task
    from tatamu.folding.task import make_task as make_task
    from tatamu.garments import make_garment as make_garment
    from tatamu.garments import register_garment as register_garment
    from tatamu.garments.garment import Garment as Garment
    from tatamu.policies.dataset import make_dataset as make_dataset
    from tatamu.policies.dataset import replay as replay
    from tatamu.robots.constraint import find_reach as find_reach
    from tatamu.search.gp import GPSearch as GPSearch
    from tatamu.search.search import Search as Search
    from tatamu.search.search import register_search as register_search
    from tatamu.search.space import Bounds as Bounds
    from tatamu.search.space import Space as Space
    from tatamu.simulation.material import Material as Material
    from tatamu.simulation.native import BodyTarget as BodyTarget
    from tatamu.simulation.native import HandTarget as HandTarget
    from tatamu.simulation.native import Simulation as Simulation
    from tatamu.simulation.native import SimulationState as SimulationState
    from tatamu.simulation.rollout import Rollout as Rollout
    from tatamu.simulation.scene import Cloth as Cloth
    from tatamu.simulation.scene import Gripper as Gripper
    from tatamu.simulation.scene import Scene as Scene
    from tatamu.simulation.scene import Table as Table
    from tatamu.simulation.simulators import register_simulator as register_simulator
    from tatamu.simulation.simulators import simulate as simulate
    from tatamu.simulation.simulators import simulate_many as simulate_many
    from tatamu.study.loop import Progress as Progress
    from tatamu.study.options import LearnOptions as LearnOptions
    from tatamu.study.plan import PlanResult as PlanResult
    from tatamu.study.result import Result as Result
    from tatamu.study.trial import Trial as Trial


def _homes() -> dict[str, str]:
    """Return the module of each public name, from the imports above."""
    (names,) = (node.body for node in ast.parse(Path(__file__).read_text("utf-8")).body if isinstance(node, ast.If))
    return {each.names[0].name: str(each.module) for each in names if isinstance(each, ast.ImportFrom)}


_HOME = _homes()
__all__ = sorted(_HOME)
_install()


_FORMER = ("CoarseFirst", "Disturbed", "TwoFidelitySearch", "WithinReach")
"""Names of version 0.2, for one version."""


def __getattr__(name: str) -> Any:
    """Import a public name."""
    if name in _FORMER:
        return getattr(import_module("tatamu.evaluation.former"), name)
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
    return [*__all__, "__version__"]
