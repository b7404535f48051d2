"""Results: the learned fold as one object, and the folder that keeps it.

Everybody who needs a learned fold takes it from here; nobody else opens its files or builds what they hold.
"""

from tatamu.results.folder import ResultFolder
from tatamu.results.inputs import Sources, keep_inputs, kept_input
from tatamu.results.learned import MOMENTS, LearnedFold, read_fold
from tatamu.results.manipulation import ArmPath, GraspPoint, ManipulationDescription, ViaPoints, describe_manipulation
from tatamu.results.margins import AloneMargin, JointMargin, MarginsResult
from tatamu.results.plan import FromFlat, PlanDescription, PlanResult, StepResult, describe_plan
from tatamu.results.rebuilt import RebuiltFold, rebuild
from tatamu.results.result import (
    Baseline,
    Crossings,
    Result,
    Scores,
    SharedStudyRecord,
    TaskDescription,
    Trial,
    describe_task,
)

__all__ = [
    "MOMENTS",
    "AloneMargin",
    "ArmPath",
    "Baseline",
    "Crossings",
    "FromFlat",
    "GraspPoint",
    "JointMargin",
    "LearnedFold",
    "ManipulationDescription",
    "MarginsResult",
    "PlanDescription",
    "PlanResult",
    "RebuiltFold",
    "Result",
    "ResultFolder",
    "Scores",
    "SharedStudyRecord",
    "Sources",
    "StepResult",
    "TaskDescription",
    "Trial",
    "ViaPoints",
    "describe_manipulation",
    "describe_plan",
    "describe_task",
    "keep_inputs",
    "kept_input",
    "read_fold",
    "rebuild",
]
