"""Modules of version 0.2 under their former names, for one version."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Sequence
from functools import partial
from importlib import import_module
from importlib.abc import Loader, MetaPathFinder
from importlib.machinery import ModuleSpec
from types import ModuleType

MOVED = {
    **dict.fromkeys(("arrays", "curves", "errors", "extras", "files", "records", "size", "version"), "base"),
    **dict.fromkeys(("body", "clearance", "heavy_strip", "material", "presets", "rollout", "scene"), "simulation"),
    "simulators": "simulation",
    **dict.fromkeys(("crossings", "meshing", "topology", "zbuffer"), "simulation.mesh"),
    "dataset": "policies",
    "disturbances": "evaluation",
    "instruments": "calibration",
    "options": "study",
}
"""Former name of a module to the room in which it is now, under the same name."""
RENAMED = {
    "calibration.edges": "calibration.elongation",
    "calibration.entry": "calibration.readings",
    "calibration.fit": "calibration.estimate",
    "calibration.guide": "calibration.measurements",
    "calibration.options": "calibration.laboratory",
    "calibration.picture": "calibration.test",
    "calibration.quantity": "calibration.readings",
    "calibration.target": "calibration.test",
    "cluster.arguments": "cluster.executor",
    "cluster.call": "cluster.versions",
    "crosscheck": "after.second_opinion",
    **dict.fromkeys(("dataset.subject", "dataset.table"), "policies.dataset.record"),
    "folding.hold": "folding.coverage",
    "folding.marks": "folding.score",
    "folding.pinch": "folding.grasps",
    "folding.proposals": "folding.plans",
    "folding.shift": "folding.manipulation",
    "disturbances.world": "evaluation.disturbances.scenario",
    "garments.apparel": "garments.dxf",
    "garments.cut": "garments.pattern",
    "garments.fibres": "garments.worn",
    "garments.foreground": "garments.photo",
    "garments.frame": "garments.units",
    "garments.laying": "garments.flat",
    "garments.openings": "garments.outline",
    "garments.pieces": "garments.drawing",
    "garments.polygons": "garments.objfile",
    "garments.resolution": "garments.garment",
    "garments.sides": "garments.outline",
    "lerobot.extras": "base.extras",
    "lerobot.layout": "lerobot.files",
    "lerobot.statistics": "lerobot.feature",
    **dict.fromkeys(("heavy_strip.cantilever", "heavy_strip.crease"), "simulation.heavy_strip"),
    "locks": "base.files",
    "margins": "after.margins",
    "margins.alone": "after.margins.measurement",
    "margins.terminal": "after.margins.texts",
    "observation": "after.feedback",
    "observation.draws": "after.feedback.observe",
    "photographs": "cameras",
    "photographs.fit": "cameras.shape",
    "photographs.lines": "cameras.edges",
    "photographs.located": "cameras.locate",
    "photographs.look": "cameras.pictures",
    "photographs.mounting": "cameras.pose",
    "photographs.opencv": "cameras",
    "photographs.printing": "cameras.board",
    "presentation": "show",
    "presentation.packing": "show.replay",
    "presentation.tube": "show.solids",
    **dict.fromkeys(("report.notebook", "report.replay"), "report.page"),
    **dict.fromkeys(("robots.bags", "robots.goals", "robots.tables"), "robots.exports"),
    "robots.contacts": "robots.stage",
    "robots.interfaces": "robots.arm",
    "robots.jaw": "robots.arm",
    "robots.kinematics": "robots.paths",
    "robots.links": "robots.stage",
    "robots.planned": "robots.planfile",
    "robots.timing": "robots.motion",
    "search.expected_improvement": "search.gp",
    "search.registry": "search.search",
    "settling": "simulation.material",
    "simulators.blender.install": "simulation.blender.discovery",
    "simulators.blender.quads": "simulation.blender.recipe",
    "simulators.capabilities": "simulation.simulators",
    "simulators.mujoco.hold": "simulation.mujoco.controlled",
    "simulators.mujoco.rigid": "simulation.mujoco.controlled",
    "simulators.native.elastic.wrinkling": "simulation.native.elastic.membrane",
    "simulators.native.memory": "simulation.native",
    "simulators.native.memory.kernel_cache": "simulation.native.compiled",
    "simulators.native.rest": "simulation.native.snapshot",
    "simulators.native.simulator": "simulation.native",
    "simulators.native.targets": "simulation.native.grippers",
    "subdivision": "simulation.mesh.meshing",
    "simulators.timeline": "simulation.scene",
    **{f"simulators.{name}": f"simulation.{name}" for name in ("blender", "mujoco", "native")},
}
"""Former name to the present one."""


def present_name(former: str) -> str | None:
    """Return the present name of a module, or None if it has none but the given one."""
    parts = former.split(".")[1:]
    for length in range(len(parts), 0, -1):
        head = ".".join(parts[:length])
        found = RENAMED.get(head) or (f"{MOVED[head]}.{head}" if head in MOVED else None)
        if found is not None:
            return ".".join(("tatamu", found, *parts[length:]))
    return None


class _Moved(MetaPathFinder, Loader):
    """Imports the present module for a former name, with a warning."""

    def find_spec(
        self, fullname: str, path: Sequence[str] | None = None, target: ModuleType | None = None
    ) -> ModuleSpec | None:
        if not fullname.startswith("tatamu.") or present_name(fullname) is None:
            return None
        return ModuleSpec(fullname, self, is_package=True)

    def create_module(self, spec: ModuleSpec) -> None:
        """Let Python make an empty module, whose attributes are those of the present one."""

    def exec_module(self, module: ModuleType) -> None:
        present = str(present_name(module.__name__))
        warnings.warn(f"{module.__name__} is now {present}", FutureWarning, stacklevel=2)
        module.__dict__["__getattr__"] = partial(getattr, import_module(present))


def install() -> None:
    """Let Python find modules under their former names."""
    if not any(isinstance(finder, _Moved) for finder in sys.meta_path):
        sys.meta_path.insert(0, _Moved())  # first, as a former package would load its modules a second time
