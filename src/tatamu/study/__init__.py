"""Studies: the options of learning, the loop over trials, the storage of trials, and the results of studies.

A study is one search for a fold, and a trial is one evaluation in this search. A world is one random draw of all
disturbances. The nominal world has no disturbances.
"""

from tatamu.study.folder import ResultFolder
from tatamu.study.learn import Places, learn
from tatamu.study.loop import Progress
from tatamu.study.plan import PlanResult
from tatamu.study.plan_record import FromFlat, PlanRecord, StepRecord
from tatamu.study.record import Crossings, ResultRecord, StudyRecord, TaskDescription
from tatamu.study.result import MOMENTS, Result
from tatamu.study.setup import check_pending, make_evaluator, resolve, usual_pending
from tatamu.study.trial import Baseline, Scored, Trial

__all__ = [
    "MOMENTS",
    "Baseline",
    "Crossings",
    "FromFlat",
    "Places",
    "PlanRecord",
    "PlanResult",
    "Progress",
    "Result",
    "ResultFolder",
    "ResultRecord",
    "Scored",
    "StepRecord",
    "StudyRecord",
    "TaskDescription",
    "Trial",
    "check_pending",
    "learn",
    "make_evaluator",
    "resolve",
    "usual_pending",
]
