"""Describes a garment on the table: pose, size, outline, and how it differs from the garment of a learned fold."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from typing import Any

import numpy as np

from tatamu.cameras.fit import Fit
from tatamu.cameras.photograph import Photograph
from tatamu.cameras.pose import Pose


@dataclass(frozen=True)
class Comparison:
    """The garment with which the cloth is compared, of a size that was given or learned."""

    size: tuple[float, float]
    """Width and length of the garment [m]."""
    area: float
    """Area of the garment [m2]."""

    def lines(self, located: Located) -> list[str]:
        """Return the differences between a located garment and this one, as lines of text."""
        sides = [
            f"{name} {100 * (now / then - 1):+.1f} %"
            for name, now, then in zip(("width", "length"), located.size, self.size, strict=True)
        ]
        share = located.area / self.area - 1
        size = f"{self.size[0]:.3f} x {self.size[1]:.3f} m"
        found = [f"compared with {size}: {', '.join(sides)}, area {100 * share:+.1f} %"]
        other = max(abs(now / then - 1) for now, then in zip(located.size, self.size, strict=True))
        if share < -0.03:
            found.append("note: the area is too small; smooth out wrinkles, or learn the fold for this size")
        elif other > 0.02:
            found.append("note: the garment has another size than in the learned fold; learn the fold for this size")
        return found


@dataclass(frozen=True)
class Located:
    """A garment that was found on the table in a photograph."""

    garment: str
    pose: Pose
    """Pose of the garment's frame in the board's frame."""
    place: Pose | None
    """Pose of the garment's frame in the robot's base frame, if the board's pose there is known."""
    deviation: tuple[float, float, float]
    """Standard deviations of x, y [m] and yaw [rad] of the garment's pose."""
    size: tuple[float, float]
    """Width and length of the garment in the photograph [m]."""
    size_deviation: tuple[float, float]
    """Standard deviations of the garment's width and length [m]."""
    area: float
    """Area inside the garment's outline [m2]."""
    outline: np.ndarray
    """Points of the outline [m], shape (n, 2), in the robot's base frame if `place` is known, otherwise in the
    board's."""
    corners: Mapping[str, np.ndarray]
    """Corners of the fitted outline by name, in the frame of `outline` [m], shape (2,)."""
    rms: float
    """Root mean square distance between the found and the fitted outline [m]."""
    learned: Comparison | None
    """Garment with which the cloth is compared, if one was learned or a size was given."""
    fit: Fit = field(repr=False)
    photograph: Photograph = field(repr=False)
    edge: np.ndarray = field(repr=False)
    """Outline in the photograph [pixels], shape (n, 2)."""
    notes: tuple[str, ...] = ()
    """Notes for the user on files that probably do not belong to the photograph."""

    def describe(self) -> dict[str, Any]:
        """Return the contents of the JSON file."""
        place = self.place
        learned = self.learned
        return {
            "version": 1,
            "garment": self.garment,
            "frame": "board" if place is None else "base",
            "pose_on_board": asdict(self.pose),
            "place": None if place is None else asdict(place),
            "deviation": dict(zip(("x", "y", "yaw"), self.deviation, strict=True)),
            "size": list(self.size),
            "size_deviation": list(self.size_deviation),
            "area": self.area,
            "corners": {name: point.tolist() for name, point in self.corners.items()},
            "outline": self.outline.round(5).tolist(),
            "outline_rms": self.rms,
            "learned": None if learned is None else {"size": list(learned.size), "area": learned.area},
        }

    def lines(self) -> list[str]:
        """Return the pose and size of the garment, with notes for the user, as lines of text."""
        x, y, yaw = self.deviation
        width, length = self.size
        lens = "" if self.photograph.view.lens is not None else " or --lens"
        angle = np.degrees((self.place or self.pose).yaw)
        frame = "board's frame" if self.place is None else "robot's base frame"
        found = [
            f"{self.garment}: {width:.3f} x {length:.3f} m, area {self.area:.4f} m2; "
            f"its outline deviates by {1e3 * self.rms:.1f} mm",
            f"pose in the {frame}: x {(self.place or self.pose).x:.4f} m (+- {1e3 * x:.1f} mm), "
            f"y {(self.place or self.pose).y:.4f} m (+- {1e3 * y:.1f} mm), yaw {angle:.2f} deg "
            f"(+- {np.degrees(yaw):.2f} deg)",
            *([] if self.learned is None else self.learned.lines(self)),
        ]
        found.extend(self.notes)
        if max(x, y) > 0.003:
            known = f"the pose is known only to within {1e3 * max(x, y):.0f} mm"
            found.append(f"note: {known}; lay the board closer, or use a second page{lens}")
        if self.place is None:
            found.append("note: --board-pose or --touch gives the --place that `tatamu plan` takes")
        else:
            found.append(f"--place {self.place}")
        return found
