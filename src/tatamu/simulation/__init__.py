"""Scenes, simulators and rollouts. A simulator is a function from a `Scene` to a `Rollout`."""
