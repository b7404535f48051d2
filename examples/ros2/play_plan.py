"""Play a plan's goals on a robot with ROS 2: python3 play_plan.py PLAN [--yes].

It sends the trajectories to the arms' FollowJointTrajectory actions and the widths to the grippers' GripperCommand
actions, step by step, and asks before the jaws close and before they open. Another answer than Enter ends it, and the
arms stay where they are.

Needs ROS 2 with rclpy, control_msgs and trajectory_msgs. It was not run on ROS 2, which cannot be installed where
tatamu is tested. Tested there (tests/robots/test_ros2_player.py): its messages have the fields and types of ROS 2
Humble, and it takes the steps in order, stops where it says, and cancels every arm if one fails.
"""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Protocol

START_IN = 0.5
"""Both arms start this long after their goals were sent [s]."""
PATIENCE = 10.0
"""Time in which an action server must appear [s]."""
SUCCEEDED = 4
"""action_msgs/GoalStatus.STATUS_SUCCEEDED."""


class Robot(Protocol):
    """What the steps need of a robot."""

    def move(self, goals: Mapping[str, Any]) -> None:
        """Drive all arms through their trajectories; returns when they have ended."""

    def grip(self, goals: Mapping[str, Any], wait: float) -> None:
        """Command all grippers and give them some time [s]."""


def play(folder: Path, robot: Robot, ask: Callable[[str], bool]) -> bool:
    """Take the steps of a plan; returns whether the last one was reached.

    Args:
        folder: The plan.
        robot: What moves.
        ask: Asks whether to go on.
    """
    goals = folder / "goals"
    for step in json.loads((goals / "steps.json").read_text())["steps"]:
        if step["do"] == "move":
            robot.move({name: json.loads((goals / file).read_text()) for name, file in step["goals"].items()})
        elif step["do"] == "grip":
            robot.grip(step["goals"], step["wait"])
        elif not ask(f"The jaws {step['before']} next." if step["before"] else "The motion goes on."):
            return False
    return True


def follow_goal(msg: Any, fields: Mapping[str, Any], start: Any) -> Any:
    """Return a FollowJointTrajectory goal; `msg` has the message classes, `start` is a builtin_interfaces Time."""
    goal = msg.FollowJointTrajectory.Goal()
    goal.trajectory.header.stamp = start
    goal.trajectory.joint_names = list(fields["trajectory"]["joint_names"])
    goal.trajectory.points = [
        msg.JointTrajectoryPoint(
            positions=point["positions"],
            velocities=point["velocities"],
            time_from_start=msg.Duration(**point["time_from_start"]),
        )
        for point in fields["trajectory"]["points"]
    ]
    goal.goal_time_tolerance = msg.Duration(**fields["goal_time_tolerance"])
    return goal


def grip_goal(msg: Any, fields: Mapping[str, Any]) -> Any:
    """Return a GripperCommand goal."""
    goal = msg.GripperCommand.Goal()
    goal.command.position = float(fields["command"]["position"])
    goal.command.max_effort = float(fields["command"]["max_effort"])
    return goal


class Ros2Robot:
    """A robot whose controllers offer both kinds of actions."""

    def __init__(self) -> None:
        import rclpy
        from builtin_interfaces.msg import Duration
        from control_msgs.action import FollowJointTrajectory, GripperCommand
        from rclpy.action import ActionClient
        from trajectory_msgs.msg import JointTrajectoryPoint

        class Messages:
            pass

        self._msg: Any = Messages()
        for kind in (Duration, FollowJointTrajectory, GripperCommand, JointTrajectoryPoint):
            setattr(self._msg, kind.__name__, kind)
        rclpy.init()
        self._ros, self._client = rclpy, ActionClient
        self._node = rclpy.create_node("tatamu_player")
        self._clients: dict[str, Any] = {}

    def move(self, goals: Mapping[str, Any]) -> None:
        """Drive all arms through their trajectories, from one moment on; if one fails, all are cancelled."""
        start = (self._node.get_clock().now() + self._ros.duration.Duration(seconds=START_IN)).to_msg()
        sent = {name: follow_goal(self._msg, fields, start) for name, fields in goals.items()}
        handles = self._send(self._msg.FollowJointTrajectory, sent)
        try:
            for name, handle in handles.items():
                found = self._wait(handle.get_result_async())
                if found.status != SUCCEEDED or found.result.error_code != 0:
                    raise RuntimeError(f"{name}: failed ({found.result.error_code} {found.result.error_string})")
        except BaseException:
            for handle in handles.values():
                self._wait(handle.cancel_goal_async())
            raise

    def grip(self, goals: Mapping[str, Any], wait: float) -> None:
        """Command all grippers; fingers that cloth stops may report failure, so results are not asked for."""
        self._send(self._msg.GripperCommand, {name: grip_goal(self._msg, fields) for name, fields in goals.items()})
        time.sleep(wait)

    def _send(self, kind: Any, goals: Mapping[str, Any]) -> dict[str, Any]:
        for name in goals:
            client = self._clients.setdefault(name, self._client(self._node, kind, name))
            if not client.wait_for_server(timeout_sec=PATIENCE):
                raise RuntimeError(f"{name}: there is no such action")
        futures = {name: self._clients[name].send_goal_async(goal) for name, goal in goals.items()}
        handles = {name: self._wait(future) for name, future in futures.items()}
        for name, handle in handles.items():
            if not handle.accepted:
                for other in handles.values():
                    if other.accepted:
                        self._wait(other.cancel_goal_async())
                raise RuntimeError(f"{name}: refused the goal")
        return handles

    def _wait(self, future: Any) -> Any:
        self._ros.spin_until_future_complete(self._node, future)
        return future.result()


def main() -> None:
    """Play the plan of the command line."""
    yes = "--yes" in sys.argv
    folder = Path(next(word for word in sys.argv[1:] if not word.startswith("--")))
    done = play(folder, Ros2Robot(), lambda text: yes or input(f"{text} Enter to go on, anything else ends: ") == "")
    print("done" if done else "ended; the arms stay where they are")


if __name__ == "__main__":
    main()
