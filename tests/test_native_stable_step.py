"""The largest stable steps: from the fastest vibrations of membrane and bending at rest."""

from __future__ import annotations

import numpy as np
import pytest

from tatamu.simulation.mesh.meshing import staggered_rectangle
from tatamu.simulation.mesh.topology import Topology, areas, lumped
from tatamu.simulation.native.elastic import curvature, membrane
from tatamu.simulation.native.elastic.stable_step import (
    ROUNDED_UP,
    bending_frequency,
    hinge_gradients,
    hinge_stiffness,
    membrane_frequency,
)
from tatamu.simulation.native.model import model_of, substeps
from tatamu.simulation.native.options import Options, StepOptions
from tatamu.simulation.scene import Cloth
from tests.physics.meshes import LAYOUTS
from tests.scenes import CLOTH

Mesh = tuple[np.ndarray, np.ndarray]


def regular() -> Mesh:
    vertices, faces = staggered_rectangle(0.1, 0.14, 0.02)
    return vertices, faces


def irregular() -> Mesh:
    plan, faces = LAYOUTS["irregular"](0.1, 0.14, 0.02)
    return np.column_stack([plan, np.zeros(len(plan))]), faces


def few() -> Mesh:
    """So few vertices that the eigenvalues are found without iteration."""
    return np.array([[0.0, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.12, 0.09, 0.0]]), np.array(
        [[0, 1, 2], [1, 3, 2]]
    )


MESHES = pytest.mark.parametrize("mesh", [regular(), irregular(), few()], ids=["regular", "irregular", "few"])


def mass_of(mesh: Mesh) -> np.ndarray:
    return lumped(areas(*mesh) * CLOTH.areal_density, mesh[1], len(mesh[0]))


def highest(stiffness: np.ndarray, mass: np.ndarray) -> float:
    """Largest angular frequency, by all eigenvalues of a dense matrix."""
    scale = 1.0 / np.sqrt(np.repeat(mass, 3))
    return float(np.sqrt(np.linalg.eigvalsh(stiffness * scale[:, None] * scale).max()))


def membrane_stiffness(mesh: Mesh) -> np.ndarray:
    """Second derivatives of the membrane's energy at rest, by finite differences of exact strains."""
    rest, faces = mesh
    frames = membrane.rest_frames(rest, faces)
    inverse = np.linalg.inv(np.stack([frames[:, 1], frames[:, 2]], axis=2))
    nu, Y = CLOTH.poisson_ratio, CLOTH.stretch_stiffness
    plane = np.array([[1, nu, 0], [nu, 1, 0], [0, 0, (1 - nu) / 2]]) * Y / (1 - nu * nu)

    def strains(x: np.ndarray) -> np.ndarray:
        corners = x[faces]
        now = np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=2) @ inverse
        green = 0.5 * (now.transpose(0, 2, 1) @ now - np.eye(2))
        return np.stack([green[:, 0, 0], green[:, 1, 1], 2 * green[:, 0, 1]], axis=1)

    slopes = []
    for coordinate in range(rest.size):
        step = np.zeros(rest.shape)
        step.flat[coordinate] = 1e-6
        slopes.append((strains(rest + step) - strains(rest - step)) / 2e-6)
    G = np.array(slopes)  # (3n, m, 3)
    return np.asarray(np.einsum("itk,t,kl,jtl->ij", G, areas(rest, faces), plane, G, optimize=True))


@MESHES
def test_the_membranes_frequency_is_that_of_the_plane_stress_sheet(mesh: Mesh) -> None:
    frames = membrane.rest_frames(*mesh)
    found = membrane_frequency(*mesh, membrane.constants(frames, CLOTH)[0], mass_of(mesh))
    exact = highest(membrane_stiffness(mesh), mass_of(mesh))
    assert (1 - 1e-6) * exact < found < ROUNDED_UP * (1 + 1e-6) * exact


@MESHES
def test_the_frequency_of_bending_is_that_of_all_hinges_together(mesh: Mesh) -> None:
    topology = Topology(mesh[1])
    free = np.zeros(len(topology.hinges), dtype=bool)
    curved = curvature.maps(mesh[0], topology, membrane.rest_frames(*mesh), free, 0.45)
    K = curvature.stiffness(curved, curvature.rigidities(CLOTH))
    at = curved.hinges
    gradient, _ = hinge_gradients(mesh[0], topology.hinges)
    stiffness = hinge_stiffness(K, at, len(topology.hinges))
    found = bending_frequency(gradient, stiffness, mass_of(mesh))
    exact = highest((gradient.T @ stiffness @ gradient).toarray(), mass_of(mesh))
    assert (1 - 1e-6) * exact < found < ROUNDED_UP * (1 + 1e-6) * exact


def test_gradients_of_dihedral_angles_are_their_finite_differences() -> None:
    rest, faces = regular()
    bent = rest + np.random.default_rng(0).normal(0.0, 0.002, rest.shape)
    hinges = Topology(faces).hinges

    def angles(x: np.ndarray) -> np.ndarray:
        return np.asarray(4.0 * np.arctan(hinge_gradients(x, hinges)[1] / 4.0))  # theta of g = 4 tan(theta / 4)

    gradient = hinge_gradients(bent, hinges)[0].toarray()
    for coordinate in np.random.default_rng(1).integers(0, bent.size, 10):
        step = np.zeros(bent.shape)
        step.flat[coordinate] = 1e-6
        slope = (angles(bent + step) - angles(bent - step)) / 2e-6
        assert gradient[:, coordinate] == pytest.approx(slope, rel=1e-4, abs=1e-4 * np.abs(gradient).max())


def test_cloth_without_an_inner_edge_never_bends() -> None:
    rest, faces = few()
    topology = Topology(faces[:1])
    gradient, _ = hinge_gradients(rest, topology.hinges)
    none = hinge_stiffness(np.zeros((0, 3, 3)), np.zeros((0, 3), dtype=np.int64), len(topology.hinges))
    assert 0.0 < bending_frequency(gradient, none, np.ones(4)) < 1e-6


@pytest.mark.parametrize("phase", [1.25, 0.6])
def test_steps_are_as_long_as_the_phase_that_is_asked_for_allows(phase: float) -> None:
    vertices, faces = regular()
    model = model_of(Cloth(vertices=vertices, faces=faces), CLOTH, Options())
    second = 1.0  # so many steps that the last, broken one makes no difference
    kicks, substeps_per_kick = substeps(model, second, StepOptions(membrane_phase=phase / 100, bending_phase=phase))
    assert 0.99 * phase < model.bending_frequency * second / kicks <= phase
    assert 0.95 * phase < 100 * model.membrane_frequency * second / kicks / substeps_per_kick <= phase
