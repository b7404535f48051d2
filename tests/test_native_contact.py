"""Which triangles a vertex is kept from, where more than two sheets meet; and how often what is crushed is swept."""

from __future__ import annotations

import numpy as np
import pytest

from tatamu.simulation.material import Material
from tatamu.simulation.native.options import ContactOptions, Options
from tatamu.simulation.native.simulation import Simulation
from tatamu.simulation.scene import Cloth, Gripper, Scene, Table
from tests.scenes import sheet as sheet_of
from tests.scenes import together

CLOTH = Material(areal_density=0.2, stretch_stiffness=100.0, bending_rigidity=1e-5, thickness=0.001)


def sheet(at: list[float], normal: list[float]) -> np.ndarray:
    """A triangle with its middle at a point and that normal, shape (3, 3)."""
    n = np.array(normal) / np.linalg.norm(normal)
    u = np.cross(n, [0.0, 0.0, 1.0] if abs(n[2]) < 0.9 else [1.0, 0.0, 0.0])
    u /= np.linalg.norm(u)
    turns = np.radians([0.0, 120.0, 240.0])
    return np.array(at) + 0.02 * (np.cos(turns)[:, None] * u + np.sin(turns)[:, None] * np.cross(n, u))


def crumple(third: np.ndarray) -> tuple[Simulation, int]:
    """A corner 0.5 mm over one sheet and 0.6 mm under another, and a third sheet; and the corner's vertex."""
    corner = np.array([[0.0, 0.0, 0.0], [0.004, -0.02, 0.0], [-0.004, -0.02, 0.0]])
    below, above = sheet([0.0, 0.0, -0.0005], [0.0, 0.0, 1.0]), sheet([0.0, 0.0, 0.0006], [0.0, 0.0, 1.0])
    cloth = Cloth(vertices=np.concatenate([corner, below, above, third]), faces=np.arange(12).reshape(4, 3))
    return Simulation(Scene(cloth=cloth, material=CLOTH, duration=0.1)), 0


def kept(third: np.ndarray, partners: list[int], sides: list[int]) -> tuple[list[int], list[int]]:
    """Partners and sides of the corner after a search, given those before."""
    simulation, corner = crumple(third)
    vertex_face = simulation.contact.vertex_face
    vertex_face.triangle[corner] = partners
    vertex_face.side[corner] = sides
    simulation.search()
    return vertex_face.triangle[corner].tolist(), vertex_face.side[corner].tolist()


ACROSS = sheet([0.0, 0.0007, 0.0], [0.0, 1.0, 0.1])
FURTHER = sheet([0.0, 0.0, -0.0009], [0.0, 0.0, 1.0])


def test_a_third_sheet_that_was_touched_stays_guarded_with_its_side() -> None:
    faces, sides = kept(ACROSS, [1, 3, -1], [1, -1, 0])
    assert set(faces[:2]) == {1, 2} and faces[2] == 3 and sides == [0, 0, -1]
    again, _ = kept(ACROSS, faces, [1, -1, -1])
    assert again == faces


@pytest.mark.parametrize("third", [FURTHER, sheet([0.0, 0.0015, 0.0], [0.0, 1.0, 0.1])])
def test_what_is_behind_a_sheet_or_no_longer_touched_is_let_go(third: np.ndarray) -> None:
    faces, _ = kept(third, [1, 3, -1], [1, 1, 0])
    assert set(faces[:2]) == {1, 2} and faces[2] == -1


def crushed(options: ContactOptions) -> Simulation:
    """A hand crushes one sheet with another onto the table, where there is room for neither, and stays there."""
    lower = sheet_of(0.1, 0.1, height=0.0005)
    count = len(lower.vertices)
    upper = Cloth(vertices=lower.vertices + np.array([0.003, 0.002, 0.001]), faces=lower.faces)
    cloth = together(lower, upper)
    down = Gripper(vertices=range(count, 2 * count), times=[0.0, 0.05], displacements=[[0, 0, 0], [0, 0, -0.0013]])
    scene = Scene(cloth=cloth, material=CLOTH, table=Table(), grippers=[down], duration=0.3)
    simulation = Simulation(scene, Options(contact=options))
    simulation.advance(8 / scene.frame_rate)
    return simulation


@pytest.mark.parametrize(
    ("options", "most"),
    [
        (ContactOptions(held=1.0), 5),
        (ContactOptions(held=1.0, sweeps_of_many=2), 2),
        (ContactOptions(held=1.0, restored=(1.0, 0.5, 0.3)), 3),
    ],
)
def test_layers_without_room_are_swept_a_few_times_in_each_of_many_rounds(options: ContactOptions, most: int) -> None:
    simulation = crushed(options)
    counters = simulation.contact.counters
    sweeps, number, rounds = int(counters.sweep), simulation.number, []
    for _ in range(40):
        simulation.advance(0.2 / simulation.scene.frame_rate)
        rounds.append(int(counters.rounds))
    assert min(rounds) > 1
    assert min(rounds) < (int(counters.sweep) - sweeps) / (simulation.number - number) <= most * max(rounds)


def test_layers_that_contact_only_holds_are_not_resolved_more_often() -> None:
    found = [int(crushed(ContactOptions(held=held)).contact.counters.rounds) for held in (1.0, ContactOptions().held)]
    assert found[0] > found[1] == 1
