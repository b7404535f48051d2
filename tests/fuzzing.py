"""Files of every kind that tatamu reads, broken at random, and what becomes of reading them: done, or one clean line.

A case follows from its seed alone: `outcome(seed)` writes a valid file, breaks it in one to three places, and reads it
as a command would.
"""

from __future__ import annotations

import contextlib
import io
import json
import re
import resource
import shutil
import struct
import sys
import tempfile
import time
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from random import Random
from typing import Any
from unittest import mock

import numpy as np
import trimesh
from PIL import Image

from tatamu.after.feedback import FORM, MeasuredFold, read_template, ruler
from tatamu.base.errors import TatamuError
from tatamu.calibration import load_measurements
from tatamu.cameras.board import Board, load_board, write_board
from tatamu.cameras.lens import Lens, load_lens, write_lens
from tatamu.cli import main
from tatamu.evaluation.disturbances.description import OWN, read_disturbances
from tatamu.evaluation.draws import read_outcomes
from tatamu.folding.plans import make_plan
from tatamu.garments import make_garment
from tatamu.policies.dataset.record import EpisodeRecord, read_outcome, row_of, write_table
from tatamu.policies.dataset.states import read_states
from tatamu.robots.catalog import described
from tatamu.robots.planfile import Planned
from tatamu.simulation.material import PRESETS, load_material
from tatamu.simulation.mesh.meshing import staggered_rectangle
from tatamu.simulation.native.simulation import Simulation
from tatamu.simulation.rollout import Rollout
from tatamu.simulation.scene import Scene
from tatamu.simulation.simulators import simulate
from tatamu.study.folder import ResultFolder
from tatamu.study.inputs import kept_input
from tatamu.study.options import TaskRequest
from tatamu.study.plan import PlanResult
from tatamu.study.result import Result
from tatamu.study.store import file_store, load_settings
from tatamu.sweep.description import read_sweep
from tests.fabricated import write_fold
from tests.foreign import svg, tshirt_svg
from tests.patterns import aama_dxf, half_dxf, hoodie_svg, inserted_dxf
from tests.photos import photograph
from tests.robots.arms import BOX, mjcf, pair, urdf
from tests.scenes import scene
from tests.small_studies import towel
from tests.test_garments_glb import WHOLE
from tests.test_garments_svg import DRAWN, NEVER_DRAWN, SHOWN
from tests.test_study_store import RECORD, finished

ODD = ("plain", "a?1", "x%41y#b&c;d", 'it\'s "so"', " a ", "Tüch 畳 🧺", "-dash", "[b]{c}$(x)*~", "a\\b", "x" * 200)
"""Names of folders."""
EXAMPLES = Path(__file__).parent.parent / "examples"
PATIENCE = 10.0
"""Reading a file takes no more time of a processor [s]: other programs do not count."""
MAX_MEMORY = 1.5
"""Reading a file takes no more memory beyond the program's own [GiB]."""
NUMBERS = (
    *"0 -1 -0.0 1e-300 1e300 1e308 -1e308 nan inf Infinity NaN 0x7f 1e999 2147483648 4294967295".split(),
    *'0.1 3 1e9 1000000 1e-12 true null "" [] 50% 3em'.split(),
    "9" * 400,
)
WORDS = {
    b"<svg": (
        *('<clipPath id="k"><rect width="50%" height="1e9"/></clipPath>', '<symbol id="s" viewBox="0 0 0 4">'),
        *('<mask id="m"><rect width="100%"/></mask>', '<pattern id="q">', '<marker id="w">', '<use href="#s"/>'),
        *('<g clip-path="url(#k)" mask="url(#m)">', "</g>", "<switch>", "<style>*{clip-path:url(#k)}</style>"),
        *('<svg width="50%" height="-50%" viewBox="0 0 1e-9 9">', '<rect width="100%" height="100%" fill="white"/>'),
    ),
    b"<robot": (
        '<safety_controller soft_lower_limit="-0.3" soft_upper_limit="1e9"/>',
        '<limit lower="0" upper="0" velocity="0"/><mimic joint="elbow" multiplier="1e9"/>',
        *('<joint name="x" type="continuous"><parent link="foot"/><child link="x"/></joint>', '<link name="x"/>'),
        *('<collision><geometry><mesh filename="package://a/../../b.stl"/></geometry></collision>', "</link>"),
        *('<mujoco><compiler meshdir=".." strippath="true"/></mujoco>', '<joint name="pan" type="floating"/>'),
    ),
    b"<mujoco": (
        *("<freejoint/>", '<joint type="ball"/>', '<include file="arm.xml"/>', '<attach model="a" body="foot"/>'),
        *('<asset><texture name="t" type="2d" builtin="flat" width="99999" height="99999"/></asset>', "</body>"),
        *('<asset><hfield name="h" nrow="99999" ncol="99999" size="1 1 1 1"/></asset>', "<default>"),
        *('<actuator><position joint="pan" ctrlrange="-0.3 0.3"/></actuator>', '<replicate count="99999">'),
        *('<equality><joint joint1="pan" joint2="lift"/></equality>', '<compiler meshdir=".." angle="degree"/>'),
    ),
    b"glTF": (
        *('"extensionsRequired": ["KHR_draco_mesh_compression"]', '"extensionsRequired": [{}]', '"normalized": true'),
        *('"skin": 0', '"matrix": [0]', '"scale": [0, 0, 0]', '"children": [0]', '"componentType": 5120'),
        *('"sparse": {"count": 1e9}', '"byteStride": 1', '"mode": 5', '"targets": [{"POSITION": 0}]'),
    ),
}
"""What stands in files of a kind, by what stands at their beginning."""
TOKENS = (
    *(b"\x00", b"\x1b[2J", b"\xff\xfe", b"\xef\xbb\xbf", b"\xc2\x9b31m", b"\xe2\x80\xae", b"\n", b"\r", b"\t"),
    *(b"<", b'"', b"{", b"]]>", b"&lt;", b"%s%n"),
    *(b"A" * 5_000, b"[" * 2_000, b"<g>" * 300, b"9" * 5_000, b"../" * 40),
)


@dataclass(frozen=True)
class Kind:
    """A kind of file."""

    name: str
    """Its file name, or that of the file in a folder."""
    write: Callable[[Path, Random], object]
    """Writes a valid one into a folder."""
    read: Callable[[Path], object]
    """Reads the folder."""


def command(*words: str) -> Callable[[Path], object]:
    """Run a command in the folder: DIR stands for it."""

    def run(folder: Path) -> None:
        given = ["tatamu", *(word.replace("DIR", str(folder)) for word in words)]
        with mock.patch.object(sys, "argv", given):
            main()

    return run


def _exported(**how: str) -> bytes:
    made: Any = _sheet().export(**how)
    return made if isinstance(made, bytes) else str(made).encode()


def _form(folder: Path, random: Random) -> None:
    (folder / "form.toml").write_text(FORM)


def _observation(folder: Path, random: Random) -> None:
    seen = ruler({"left": (random.gauss(0.0, 0.01), 0.0), "slip": (0.001, 0.0)}, 0.5, turned_in=["right"])
    (folder / "1.json").write_text(seen.model_dump_json())


def _ply(folder: Path, random: Random) -> None:
    (folder / "g.ply").write_bytes(_exported(file_type="ply", encoding=random.choice(["ascii", "binary"])))


def _stl(folder: Path, random: Random) -> None:
    (folder / "g.stl").write_bytes(_exported(file_type=random.choice(["stl", "stl_ascii"])))


@cache
def _sheet() -> trimesh.Trimesh:
    vertices, faces = staggered_rectangle(0.3, 0.4, 0.06)
    return trimesh.Trimesh(vertices, faces, process=False)


def _mesh(kind: str) -> Callable[[Path, Random], object]:
    """A flat sheet: one that is not flat may be simulated as it falls, which takes a minute and is no fault."""
    return lambda folder, random: _sheet().export(folder / f"g.{kind}")


def _svg(folder: Path, random: Random) -> None:
    shapes = [
        hoodie_svg('width="620mm" height="710mm" viewBox="0 0 620 710"'),
        svg('<defs><path id="p" d="M10,10 h300 v400 h-300 z"/></defs><use href="#p"/><circle cx="90" cy="90" r="40"/>'),
        svg(
            '<g transform="scale(0.5)"><path d="M0 0 C 9 0 600 0 600 0 A 300 400 0 0 1 600 800 Q 300 900 0 800 Z"/></g>'
        ),
        tshirt_svg(folder).read_text(),
        *(svg(drawn, 340, 440) for drawn in DRAWN.values()),
        *(svg(hidden + SHOWN, 340, 440) for hidden in NEVER_DRAWN.values()),
    ]
    (folder / "g.svg").write_text(random.choice(shapes))


def _dxf(folder: Path, random: Random) -> None:
    made = random.choice([aama_dxf, half_dxf, lambda place: inserted_dxf(place, 4, 1e-3), _curved_dxf])(folder)
    shutil.move(made, folder / "g.dxf")


def _curved_dxf(folder: Path) -> Path:
    import ezdxf

    document = ezdxf.new()  # type: ignore[attr-defined]
    space = document.modelspace()
    space.add_lwpolyline([(0, 0, 0.2), (300, 0, 0), (300, 400, 0), (0, 400, -0.1)], format="xyb", close=True)
    space.add_ellipse((150, 200), (60, 0), 0.5)
    space.add_spline([(20, 20), (40, 60), (90, 30), (20, 20)])
    document.saveas(folder / "curved.dxf")
    return folder / "curved.dxf"


def _photo(folder: Path, random: Random) -> None:
    _photographed(folder)
    kind = random.choice(["PNG", "JPEG", "BMP", "TIFF", "WEBP", "GIF", "12 bits", "16 bits", "floats"])
    with Image.open(folder / "p.png") as image:
        small = image.convert("RGB").resize((200, 150))
    if kind in ("12 bits", "16 bits", "floats"):
        import cv2

        factor, of = {"12 bits": (4095 / 255, "u2"), "16 bits": (257.0, "u2"), "floats": (1 / 255, "f4")}[kind]
        written = cv2.imencode(".tif" if kind == "floats" else ".png", (np.asarray(small) * factor).astype(of))[1]
        (folder / "p.img").write_bytes(written.tobytes())
    else:
        stated = Image.Exif()
        stated[274] = random.randint(1, 8)
        small.save(folder / "p.img", format=kind, exif=stated)


def _glb(folder: Path, random: Random) -> None:
    (folder / "g.glb").write_bytes(random.choice([*WHOLE.values()])().bytes())


@cache
def _photo_bytes() -> bytes:
    with tempfile.TemporaryDirectory() as folder:
        photograph(Path(folder) / "p.png", (60, 90, 170), (150, 110, 75))
        return (Path(folder) / "p.png").read_bytes()


def _photographed(folder: Path) -> None:
    (folder / "p.png").write_bytes(_photo_bytes())


def _copied(source: Path, name: str) -> Callable[[Path, Random], object]:
    return lambda folder, random: shutil.copy(source, folder / name)


def _scene(folder: Path, random: Random) -> None:
    scene(duration=0.05).save(folder / "s.json")


def _simulated(folder: Path) -> object:
    return Simulation(Scene.load(folder / "s.json"))


def _garment(folder: Path, random: Random) -> None:
    tshirt_svg(folder)
    lines = ["[garment]", 'outline = "shirt.svg"', 'openings = ["hem", "neck"]', "scale = 0.001", "spacing = 0.03"]
    lines += ["size = [0.5, 0.4]", 'fabric = "denim"'] if random.random() < 0.5 else ['up = "-y"', "layers = 2"]
    (folder / "g.toml").write_text("\n".join(lines))


PLAN = 'name = "mine"\n[[step]]\nline = [[0.0, -0.5], [0.0, 0.5]]\nmoves = "+x"\n'


def _plan(folder: Path, random: Random) -> None:
    (folder / "plan.toml").write_text("[plan]\n" + PLAN)


def _fold(name: str) -> Callable[[Path, Random], object]:
    def write(folder: Path, random: Random) -> None:
        write_fold(folder, spacing=0.1, count=3, frames=4)

    return write


def _rollout(folder: Path, random: Random) -> None:
    positions = np.zeros((2, 3, 3))
    compress = np.savez_compressed if random.random() < 0.5 else np.savez
    compress(
        folder / "r.npz", times=np.arange(2.0), positions=positions, faces=np.array([[0, 1, 2]]), info=np.array("{}")
    )


TRAJECTORY = "time,a,b\n" + "".join(f"{0.1 * k:.1f},{0.01 * k:.2f},{-0.02 * k:.2f}\n" for k in range(40))
EVENTS = [
    {"time": time, "arm": arm, "event": event}
    for arm in ("larm", "rarm")
    for time, event in ((1.0, "close"), (3.0, "open"))
]


def _arm(folder: Path, random: Random) -> None:
    """A pair of arms that states soft limits, continuous joints, drives, masses or meshes."""
    pair(folder)
    (folder / "link.stl").write_bytes(trimesh.creation.box([0.06, 0.06, 0.05]).export(file_type="stl"))
    soft = "<safety_controller soft_lower_limit='-1' soft_upper_limit='1'/></joint>"
    mesh = '<mesh filename="package://arms/link.stl"/>'
    plain, continuous = urdf(), urdf().replace('"pan" type="revolute"', '"pan" type="continuous"')
    heavy = plain.replace('izz="0.01"', 'izz="9"', 1)
    texts = (plain.replace("</joint>", soft, 1), continuous, heavy, urdf(mesh), urdf(f"<!-- {mesh} -->{BOX}"))
    (folder / "arm.urdf").write_text(random.choice(texts))
    drive = '<actuator><position joint="pan" kp="50" ctrlrange="-1 1"/></actuator>'
    asset = '<asset><mesh name="m" file="link.stl"/></asset>'
    shown = '<geom type="mesh" mesh="m"/>'
    (folder / "arm.xml").write_text(random.choice([mjcf(more=drive), mjcf(more=asset, hand=shown)]))
    described = (folder / "pair.toml").read_text()
    (folder / "pair.toml").write_text('packages = { arms = "." }\n' + described)


def _states(folder: Path, random: Random) -> None:
    """The arrays of two episodes, as they are written here or as Zarr 2 writes them."""
    import zarr

    format = random.choice([3, 3, 2])
    group = zarr.open_group(store=str(folder / "states.zarr"), mode="w", zarr_format=format)  # type: ignore[arg-type]
    for name, array in {"length": np.array([3, 2]), "action": np.ones((2, 3, 8), dtype="f4")}.items():
        group.create_array(name, data=array)
    if format == 2:  # under the names of Zarr 3
        for file in (folder / "states.zarr").rglob(".z*"):
            shutil.copy(file, file.with_name("zarr.json"))
        chunk = folder / "states.zarr" / "action" / "c" / "0" / "0" / "0"
        chunk.parent.mkdir(parents=True)
        shutil.copy(folder / "states.zarr" / "action" / "0.0.0", chunk)


def _episodes(folder: Path, random: Random) -> None:
    plain: dict[str, Any] = {"task": "", "source": "drawn", "garment": "towel", "plan": "half", "material": {}}
    plain |= {"parameters": {}, "world": {}, "frames": 1, "vertices": 2, "score": None, "success": True}
    records = [EpisodeRecord(episode=k, fold=0, **plain) for k in range(3)]
    write_table(folder / "episodes.parquet", [row_of(record, np.zeros((2, 3))) for record in records])


def _read_states(folder: Path) -> object:
    return read_states(folder / "states.zarr", 1, ["action"])


def _inputs(folder: Path, random: Random) -> None:
    (folder / "inputs").mkdir()
    material = random.choice(["material/m.toml", "../m.toml", "/m.toml"])
    (folder / "inputs" / "files.json").write_text(json.dumps({"garment": "garment/a.svg", "material": material}))


def _several(folder: Path, random: Random) -> None:
    """The record of a plan of two steps, which a foreign one may say to lie elsewhere."""
    write_fold(folder / "step-1", spacing=0.1, count=3, frames=4)
    shutil.copytree(folder / "step-1", folder / "step-2")
    shutil.copy(folder / "step-1" / "rollout.npz", folder)
    fold = json.loads((folder / "step-1" / "result.json").read_text())
    distances = {"mean_vertex_distance": 0.01, "mask_iou": 0.9, "area_error": 1.0}
    trial = next(trial for trial in fold["trials"] if trial["number"] == fold["best"])
    step = {**trial, "title": "in half", "hands": 2, "trials": 3, "best": 0, "crossings": {"final": 0, "most": 0}}
    step["whole"] = distances
    elsewhere = random.choice(
        ["step-2", "step-2", "../elsewhere", "step-1/../step-2", "/step-2", "javascript:0", "step-0"]
    )
    steps = [{**step, "folder": "step-1"}, {**step, "folder": elsewhere}]
    record = {**{name: fold[name] for name in ("sampler", "grasps", "seed", "wall_seconds")}, "plan": fold["task"]}
    (folder / "result.json").write_text(json.dumps({**record, "version": 1, "steps": steps, "final": distances}))


def _robot_plan(folder: Path, random: Random) -> None:
    (folder / "joint_trajectory.csv").write_text(TRAJECTORY)
    pose = {"xyz": [0.3, 0.0, 0.0], "yaw": 0.1}
    plan = {"version": 1, "robot": "r", "base_frame": "b", "task_in_base": pose, "joints": ["a", "b"], "events": EVENTS}
    (folder / "plan.json").write_text(json.dumps(plan))


def _pair(folder: Path, random: Random) -> None:
    pair(folder)


def _study(folder: Path, random: Random) -> None:
    with file_store(ResultFolder(folder)) as store:
        store.open(RECORD)
        for number in range(2):
            store.add(finished(number), towel().space)


def _changed_study(folder: Path) -> object:
    """Read the study of a folder as `learn` does."""
    kept = load_settings(ResultFolder(folder), None)
    with file_store(ResultFolder(folder)) as store:
        return store.open(kept or RECORD), store.baselines


def _verdicts(folder: Path, random: Random) -> None:
    line = {"key": "k", "mean_vertex_distance": 0.01, "mask_iou": 0.9}
    (folder / "simulated.jsonl").write_text("".join(json.dumps({**line, "key": f"k{k}"}) + "\n" for k in range(9)))


def _outline(*words: str) -> Callable[[Path], object]:
    return command("outline", "DIR/p.img", "--width", "0.5", "--out", "DIR/o.svg", *words)


def _show(name: str, *words: str) -> Callable[[Path], object]:
    return command("show", f"DIR/{name}", "--out", "DIR/g.png", *words)


def _board(folder: Path, random: Random) -> None:
    write_board(Board(pages=random.randint(1, 8)), folder / "board.toml", folder / "board.pdf")


def _lens(folder: Path, random: Random) -> None:
    lens = Lens(width=1600, height=1200, focal=random.uniform(800, 2000), centre=(800.0, 600.0), distortion=(0.1, -0.2))
    write_lens(lens, folder / "lens.toml")


KINDS = (
    Kind("g.svg", _svg, _show("g.svg", "--spacing", "0.04")),
    Kind("g.svg", _svg, _show("g.svg", "--size", "0.3x0.4")),
    Kind("g.dxf", _dxf, _show("g.dxf", "--spacing", "0.04", "--size", "0.3x0.4")),
    Kind("g.obj", _mesh("obj"), _show("g.obj")),
    Kind("g.ply", _ply, _show("g.ply")),
    Kind("g.stl", _stl, _show("g.stl")),
    Kind("g.glb", _mesh("glb"), _show("g.glb")),
    Kind("g.glb", _glb, _show("g.glb")),
    Kind("g.toml", _garment, _show("g.toml")),
    Kind("p.img", _photo, _outline()),
    Kind("s.json", _scene, _simulated),
    Kind("m.toml", _copied(PRESETS / "cotton.toml", "m.toml"), lambda folder: load_material(folder / "m.toml")),
    Kind(
        "m.toml",
        _copied(EXAMPLES / "measurements-towel.toml", "m.toml"),
        lambda folder: load_measurements(folder / "m.toml"),
    ),
    Kind("d.toml", _copied(OWN / "default.toml", "d.toml"), lambda folder: read_disturbances(folder / "d.toml")),
    Kind("board.toml", _board, lambda folder: load_board(folder / "board.toml")),
    Kind("lens.toml", _lens, lambda folder: load_lens(folder / "lens.toml")),
    Kind("plan.toml", _plan, lambda folder: make_plan(str(folder / "plan.toml"), make_garment("towel", spacing=0.08))),
    Kind(
        "sweep.toml",
        _copied(EXAMPLES / "sweep.toml", "sweep.toml"),
        lambda f: read_sweep(f / "sweep.toml", TaskRequest),
    ),
    Kind("r.npz", _rollout, lambda folder: Rollout.load(folder / "r.npz")),
    Kind("result.json", _fold("result.json"), Result.load),
    Kind("plan.json", _robot_plan, Planned.load),
    Kind("joint_trajectory.csv", _robot_plan, Planned.load),
    Kind("result.json", _several, PlanResult.load),
    Kind("inputs/files.json", _inputs, lambda folder: (kept_input(folder, "garment"), kept_input(folder, "material"))),
    Kind("states.zarr/zarr.json", _states, _read_states),
    Kind("states.zarr/action/zarr.json", _states, _read_states),
    Kind("states.zarr/action/c/0/0/0", _states, _read_states),
    Kind("episodes.parquet", _episodes, lambda folder: read_outcome(folder / "episodes.parquet", 1)),
    Kind("pair.toml", _pair, lambda folder: described(folder / "pair.toml")),
    Kind("arm.urdf", _pair, lambda folder: described(folder / "pair.toml")),
    Kind("arm.xml", _pair, lambda folder: described(folder / "pair.toml")),
    Kind("arm.urdf", _arm, lambda folder: described(folder / "pair.toml")),
    Kind("arm.xml", _arm, lambda folder: described(folder / "pair.toml")),
    Kind("link.stl", _arm, lambda folder: described(folder / "pair.toml")),
    Kind("study.db", _study, _changed_study),
    Kind("simulated.jsonl", _verdicts, lambda folder: read_outcomes(folder / "simulated.jsonl").get("k1")),
    Kind("manipulation.json", _fold("manipulation.json"), lambda folder: Result.load(folder).manipulation),
    Kind("form.toml", _form, lambda folder: read_template(folder / "form.toml", 0.5)),
    Kind("1.json", _observation, lambda folder: MeasuredFold.load(folder / "1.json")),
)
"""Every kind of file, and how it is read."""


def broken(data: bytes, random: Random) -> bytes:
    """A file broken in one to three places."""
    for _ in range(random.randint(1, 3)):
        data = random.choice(BREAKS)(data, random)
    return data


def _at(data: bytes, random: Random) -> int:
    return random.randrange(len(data) + 1)


def _flip(data: bytes, random: Random) -> bytes:
    found = bytearray(data)
    for _ in range(random.choice([1, 1, 2, 8])):
        if found:
            found[random.randrange(len(found))] = random.randrange(256)
    return bytes(found)


def _cut_off(data: bytes, random: Random) -> bytes:
    return data[: _at(data, random)]


def _left_out(data: bytes, random: Random) -> bytes:
    start = _at(data, random)
    return data[:start] + data[start + random.choice([1, 4, 30, 400]) :]


def _repeated(data: bytes, random: Random) -> bytes:
    start = _at(data, random)
    return data[:start] + data[start : start + 200] * random.choice([2, 30, 500]) + data[start + 200 :]


def _inserted(data: bytes, random: Random) -> bytes:
    start = _at(data, random)
    return data[:start] + random.choice(TOKENS) + data[start:]


def _renumbered(data: bytes, random: Random) -> bytes:
    places = list(re.finditer(rb"-?[0-9][0-9.eE+-]*", data[:200_000]))
    if not places:
        return _flip(data, random)
    found = random.choice(places)
    return data[: found.start()] + random.choice(NUMBERS).encode() + data[found.end() :]


def _lines_moved(data: bytes, random: Random) -> bytes:
    lines = data.split(b"\n")
    first, second = random.randrange(len(lines)), random.randrange(len(lines))
    lines[first], lines[second] = lines[second], lines[first]
    return b"\n".join(lines)


def _words_added(data: bytes, random: Random) -> bytes:
    """What other files of the kind contain, after a random element or in a random object."""
    words = next((words for start, words in WORDS.items() if start in data[:2_000]), None)
    if words is None:
        return _inserted(data, random)
    word = random.choice(words).encode()
    if data.startswith(b"glTF"):
        return _header_changed(data, lambda text: _after(text, b"{", word + b", ", random))
    return _after(data, b">", word, random)


def _after(data: bytes, mark: bytes, word: bytes, random: Random) -> bytes:
    places = [found.end() for found in re.finditer(re.escape(mark), data)]
    place = random.choice(places or [0])
    return data[:place] + word + data[place:]


def _header_changed(data: bytes, change: Callable[[bytes], bytes]) -> bytes:
    """A GLB whose JSON is changed, and whose lengths fit."""
    end = min(20 + int.from_bytes(data[12:16], "little"), len(data))
    text = change(data[20:end])
    text += b" " * (-len(text) % 4)
    length = struct.pack("<I", len(data) - end + 20 + len(text))
    return data[:8] + length + struct.pack("<I", len(text)) + data[16:20] + text + data[end:]


def _value_replaced(data: bytes, random: Random) -> bytes:
    """JSON with another value somewhere."""
    if data.startswith(b"glTF"):
        return _header_changed(data, lambda text: _value_replaced(text, random))
    try:
        value = json.loads(data)
    except (ValueError, RecursionError):
        return _renumbered(data, random)
    place: Any = value
    while isinstance(place, list | dict) and place:
        key = random.choice(list(place) if isinstance(place, dict) else range(len(place)))
        if random.random() < 0.3 or not isinstance(place[key], list | dict):
            place[key] = random.choice(
                [None, -1, 1e308, "\x1b[2J", [], {}, [[]], True, 10**30, float("nan"), [1.5] * 9]
            )
            break
        place = place[key]
    return json.dumps(value).encode()


BREAKS = (
    _flip,
    _cut_off,
    _left_out,
    _repeated,
    _inserted,
    _renumbered,
    _renumbered,
    _lines_moved,
    _value_replaced,
    _words_added,
)


def outcome(seed: int, whole: bool = False) -> str:
    """What became of reading a broken file, or a whole one: "NAME: read", "NAME: refused", or "WRONG: .." and why."""
    random = Random(seed)
    kind = KINDS[seed % len(KINDS)]
    with tempfile.TemporaryDirectory(prefix="tatamu-fuzz-") as name:
        folder = Path(name, random.choice(ODD))
        folder.mkdir()
        kind.write(folder, random)
        path = folder / kind.name
        if not whole:
            path.write_bytes(broken(path.read_bytes(), random))
        return _judged(kind, folder)


def warm() -> None:
    """Compile what a file may need, which is no file's time."""
    simulate(scene(duration=1 / 60))


def acceptable(kind: str) -> bool:
    """Whether an outcome is as it should be."""
    return not kind.startswith("WRONG")


def _judged(kind: Kind, folder: Path) -> str:
    said = io.StringIO()
    printed = io.StringIO()
    before = _memory()
    start = time.process_time()
    with contextlib.redirect_stderr(said), contextlib.redirect_stdout(printed), warnings.catch_warnings():
        warnings.simplefilter("ignore")
        try:
            kind.read(folder)
            code = 0
        except TatamuError as error:
            code = 2
            print(f"tatamu: {error}", file=said)
        except SystemExit as error:
            code = int(error.code or 0)
        except BaseException as error:
            return f"WRONG: {kind.name}: {type(error).__name__}: {error}".splitlines()[0]
    return _reviewed(
        kind.name, code, said.getvalue(), printed.getvalue(), time.process_time() - start, _memory() - before
    )


def _reviewed(name: str, code: int, said: str, printed: str, seconds: float, memory: float) -> str:
    lines = said.splitlines()
    if code not in (0, 2):
        return f"WRONG: {name}: exit code {code}"
    if (code == 0 and lines) or (code == 2 and (len(lines) != 1 or not lines[0].startswith("tatamu: "))):
        return f"WRONG: {name}: exit code {code} with {len(lines)} lines, {said[:200]!r}"
    if not (said + printed).replace("\n", "").isprintable():
        return f"WRONG: {name}: control characters in {(said + printed)[:300]!r}"
    if seconds > PATIENCE:
        return f"WRONG: {name}: {seconds:.0f} s"
    if memory > MAX_MEMORY:
        return f"WRONG: {name}: {memory:.1f} GiB"
    return f"{name}: {'refused' if code else 'read'}"


def _memory() -> float:
    """The most memory that this process took so far [GiB]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / (1 << 20)
