"""Turns a learned fold into joint trajectories of a dual-arm robot, which are then checked, rehearsed and exported.

hands ─▶ reach ─▶ paths ─▶ motion ─▶ checks ─▶ plan ─▶ folder ─▶ rehearsal
"""

from __future__ import annotations

from tatamu.robots.arm import Arm
from tatamu.robots.catalog import load
from tatamu.robots.constraint import ReachConstraint, find_reach
from tatamu.robots.folder import check_out, save
from tatamu.robots.model import Robot
from tatamu.robots.plan import RobotPlan, plan_fold

__all__ = ["Arm", "ReachConstraint", "Robot", "RobotPlan", "check_out", "find_reach", "load", "plan_fold", "save"]
