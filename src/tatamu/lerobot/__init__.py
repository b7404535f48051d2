"""Datasets in the format LeRobotDataset v3.0: the contents of the frames, a writer, and a reader.

    with LeRobotWriter(folder, fps=30, features={"action": vector(names), "observation.images.top": camera(96)}) as out:
        out.add_episode({"action": actions, "observation.images.top": pictures}, task="Fold the towel.")

pyarrow and PyAV are imported only when they are needed. The extra `tatamu[dataset]` installs them.
"""

from tatamu.lerobot.feature import Feature, camera, flag, vector
from tatamu.lerobot.reader import LeRobotReader
from tatamu.lerobot.writer import LeRobotWriter

__all__ = ["Feature", "LeRobotReader", "LeRobotWriter", "camera", "flag", "vector"]
