"""Datasets in the format LeRobotDataset v3.0: a writer and a reader.

For example::

    with LeRobotWriter(folder, fps=30, features={"action": vector(names), "observation.images.top": camera(96)}) as out:
        out.add_episode({"action": actions, "observation.images.top": pictures}, task="Fold the towel.")
"""

from tatamu.lerobot.feature import Feature, camera, flag, vector
from tatamu.lerobot.reader import LeRobotReader
from tatamu.lerobot.writer import LeRobotWriter

__all__ = ["Feature", "LeRobotReader", "LeRobotWriter", "camera", "flag", "vector"]
