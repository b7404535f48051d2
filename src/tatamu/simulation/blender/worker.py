"""A program that runs inside Blender, reads recipes from standard input and writes positions to standard output.

`tatamu.simulation.blender.process` starts it, and it imports nothing from tatamu and needs no numpy. A message is MARK,
the length of the JSON text as four bytes (little endian), and the JSON text. In a reply, `bytes` bytes of float32
positions follow. Blender itself also prints to standard output, so the reader skips everything until the next MARK;
after the first message, everything except replies is sent to standard error.
"""

from __future__ import annotations

import json
import os
import queue
import struct
import sys
import threading
import time
from array import array
from collections.abc import Iterator
from itertools import pairwise
from typing import Any, BinaryIO

import bpy

MARK = b"\x00\xfftatamu\xff\x00"
IDENTITY = ((1, 0, 0, 0), (0, 1, 0, 0), (0, 0, 1, 0), (0, 0, 0, 1))


def main() -> None:
    """Simulate each recipe and send the answer, until standard input ends."""
    out = os.fdopen(os.dup(1), "wb")
    os.dup2(2, 1)
    recipes: queue.Queue[dict[str, Any]] = queue.Queue()
    threading.Thread(target=listen, args=(sys.stdin.buffer, recipes), daemon=True).start()
    send(out, {"blender": bpy.app.version_string})
    while True:
        try:
            reply, positions = run(recipes.get())
        except Exception as error:
            reply, positions = {"error": f"{type(error).__name__}: {error}"}, b""
        send(out, {**reply, "bytes": len(positions)}, positions)


def listen(source: BinaryIO, recipes: queue.Queue[dict[str, Any]]) -> None:
    """Put recipes from `source` on the queue; when the input ends, end this program, even during a simulation."""
    try:
        while len(header := source.read(len(MARK) + 4)) == len(MARK) + 4:
            recipes.put(json.loads(source.read(struct.unpack("<I", header[-4:])[0])))
    finally:
        os._exit(0)


def send(out: BinaryIO, message: dict[str, Any], payload: bytes = b"") -> None:
    """Write one message, and the bytes `payload` after it."""
    text = json.dumps(message).encode()
    out.write(MARK + struct.pack("<I", len(text)) + text + payload)
    out.flush()


def run(recipe: dict[str, Any]) -> tuple[dict[str, Any], bytes]:
    """Build the scene of a recipe, simulate it, and return the answer and the positions."""
    begin = time.perf_counter()
    clear()
    scene = bpy.context.scene
    scene.gravity = recipe["gravity"]
    scene.frame_start, scene.frame_end = 1, len(recipe["segments"]) + 1
    cloth = mesh_object("cloth", recipe["vertices"], recipe["faces"])
    cloth.vertex_groups.new(name="held")
    hands = [HookedVertices(cloth, number, grip) for number, grip in enumerate(recipe["grippers"])]
    if not hands:
        weigh(cloth, "nothing", [])
    modifier = add_cloth(cloth, recipe)
    if recipe["collider"] is not None:
        add_table(recipe["collider"])
    if recipe["segments"]:
        animate(cloth, modifier, hands, recipe["segments"])
    ready = time.perf_counter()
    positions = step(cloth, hands, recipe["segments"])
    return {"setup_seconds": ready - begin, "wall_seconds": time.perf_counter() - ready}, positions


def clear() -> None:
    """Remove everything that the previous recipe made."""
    bpy.context.scene.frame_set(0)
    for kind in (bpy.data.objects, bpy.data.meshes, bpy.data.actions):
        for item in list(kind):
            kind.remove(item)


def mesh_object(name: str, vertices: list[list[float]], faces: list[list[int]]) -> Any:
    """Return a new mesh object in Blender's scene."""
    mesh = bpy.data.meshes.new(name)
    mesh.from_pydata(vertices, [], faces)
    made = bpy.data.objects.new(name, mesh)
    bpy.context.scene.collection.objects.link(made)
    return made


def weigh(cloth: Any, name: str, vertices: list[int]) -> Any:
    """Return a modifier that adds a group of vertices to the held ones, by a factor from 0 to 1 that can be animated.

    If the group itself were edited during a simulation, Blender would rebuild all springs from the present shape.
    """
    cloth.vertex_groups.new(name=name).add(vertices, 1.0, "REPLACE")
    modifier = cloth.modifiers.new(f"hold {name}", "VERTEX_WEIGHT_MIX")
    modifier.vertex_group_a, modifier.vertex_group_b = "held", name
    modifier.mix_set, modifier.mix_mode = "B", "ADD"
    modifier.mask_constant = 0.0
    return modifier


class HookedVertices:
    """One gripper: a weight that holds its vertices, and hooks that carry the vertices.

    A hand that closes at the start has one hook for all its vertices. A hand that closes later has one for each,
    because the vertices have moved until then.
    """

    def __init__(self, cloth: Any, number: int, grip: dict[str, Any]) -> None:
        self.start = [cloth.data.vertices[vertex].co.copy() for vertex in grip["vertices"]]
        self.vertices = grip["vertices"]
        self.weight = weigh(cloth, f"hand {number}", self.vertices)
        parts = [[vertex] for vertex in self.vertices] if grip["late"] else [self.vertices]
        self.hooks = [self.hook(cloth, f"hook {number} {part}", group) for part, group in enumerate(parts)]
        self.offsets = [(0.0, 0.0, 0.0) for _ in parts]
        self.late, self.closed = grip["late"], False

    @staticmethod
    def hook(cloth: Any, name: str, vertices: list[int]) -> Any:
        """Return a new object without a shape that carries the given vertices along when it moves."""
        empty = bpy.data.objects.new(name, None)
        bpy.context.scene.collection.objects.link(empty)
        cloth.vertex_groups.new(name=name).add(vertices, 1.0, "REPLACE")
        modifier = cloth.modifiers.new(name, "HOOK")
        modifier.object, modifier.vertex_group, modifier.falloff_type = empty, name, "NONE"
        modifier.matrix_inverse = IDENTITY
        return empty

    def move(self, now: array[float], displacement: list[float] | None) -> None:
        """Move the vertices by `displacement` from where the hand closed, or release them if it is None."""
        if displacement is not None and not self.closed and self.late:
            self.offsets = [
                tuple(now[3 * vertex + k] - start[k] for k in range(3))
                for vertex, start in zip(self.vertices, self.start, strict=True)
            ]
        self.closed = displacement is not None
        for empty, offset in zip(self.hooks, self.offsets, strict=True):
            empty.location = [a + b for a, b in zip(offset, displacement, strict=True)] if displacement else (0, 0, 0)


def add_cloth(cloth: Any, recipe: dict[str, Any]) -> Any:
    """Add the cloth modifier and return it. It must be the last modifier of the object."""
    if recipe["rest"] is not None:
        cloth.shape_key_add(name="start", from_mix=False)
        rest = cloth.shape_key_add(name="rest", from_mix=False)
        rest.data.foreach_set("co", array("f", [c for point in recipe["rest"] for c in point]))
        rest.value = 0.0
    if recipe["bends"] is not None:
        group = cloth.vertex_groups.new(name="bends")
        group.add(recipe["bends"], 1.0, "REPLACE")
    modifier = cloth.modifiers.new("cloth", "CLOTH")
    modifier.point_cache.frame_start, modifier.point_cache.frame_end = 1, len(recipe["segments"]) + 1
    modifier.settings.vertex_group_mass = "held"
    if recipe["bends"] is not None:
        modifier.settings.vertex_group_bending = "bends"
    if recipe["rest"] is not None:
        modifier.settings.rest_shape_key = cloth.data.shape_keys.key_blocks["rest"]
    assign(modifier.settings, recipe["settings"])
    assign(modifier.collision_settings, recipe["collision"])
    return modifier


def add_table(collider: dict[str, Any]) -> None:
    """Add the table, a triangle with which the cloth collides."""
    table = mesh_object("table", collider["vertices"], [[0, 1, 2]])
    table.modifiers.new("collision", "COLLISION")
    assign(table.collision, collider["settings"])


def assign(target: Any, values: dict[str, Any]) -> None:
    """Set properties by the alphabet, so *_stiffness before *_stiffness_max, which Blender never lets be smaller."""
    for name, value in sorted(values.items()):
        setattr(target, name, value)


def animate(cloth: Any, modifier: Any, hands: list[HookedVertices], segments: list[dict[str, Any]]) -> None:
    """Set the durations of frames and the frames in which each hand holds, by constant keyframes.

    Keyframes do not make Blender rebuild the springs.
    """
    key(modifier.settings, "time_scale", [segment["time_scale"] for segment in segments])
    for number, hand in enumerate(hands):
        held = [1.0 if segment["displacements"][number] is not None else 0.0 for segment in segments]
        key(hand.weight, "mask_constant", held)
    if cloth.animation_data is not None:
        for curve in curves(cloth.animation_data.action):
            for point in curve.keyframe_points:
                point.interpolation = "CONSTANT"


def curves(action: Any) -> Iterator[Any]:
    """Yield all curves of an action, Blender's record of keyframes, which Blender 5 stores in layers."""
    if hasattr(action, "fcurves"):
        yield from action.fcurves
        return
    for layer in action.layers:
        for strip in layer.strips:
            for bag in strip.channelbags:
                yield from bag.fcurves


def key(owner: Any, name: str, values: list[float]) -> None:
    """Set the values of a property in the frames 2, 3, ... by keyframes where it changes; frame 1 is like frame 2."""
    setattr(owner, name, values[0])
    if len(set(values)) == 1:
        return
    owner.keyframe_insert(name, frame=1)
    for frame, (last, value) in enumerate(pairwise(values), start=3):
        if value != last:
            setattr(owner, name, value)
            owner.keyframe_insert(name, frame=frame)


def step(cloth: Any, hands: list[HookedVertices], segments: list[dict[str, Any]]) -> bytes:
    """Simulate all frames, and return the positions in the wanted frames after the first, as bytes."""
    frames = bytearray()
    bpy.context.scene.frame_set(1)
    for frame, segment in enumerate(segments, start=2):
        now = positions_of(cloth)
        for hand, displacement in zip(hands, segment["displacements"], strict=True):
            hand.move(now, displacement)
        bpy.context.scene.frame_set(frame)
        if segment["wanted"]:
            frames += positions_of(cloth).tobytes()
    return bytes(frames)


def positions_of(cloth: Any) -> array[float]:
    """Return the present positions of the n vertices in Blender's coordinates, as 3n numbers."""
    mesh = cloth.evaluated_get(bpy.context.evaluated_depsgraph_get()).data
    values = array("f", bytes(12 * len(mesh.vertices)))
    mesh.vertices.foreach_get("co", values)
    return values


if __name__ == "__main__":
    main()
