"""Forces of the embedded simulator: gradients of their energies, and energies that are right."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest

from tatamu.garments import make_garment
from tatamu.simulation.material import Material
from tatamu.simulation.mesh.meshing import staggered_rectangle
from tatamu.simulation.mesh.topology import Topology, areas
from tatamu.simulation.native.bands import BLOCK, Bands, bands, slots, turned, turned_hinges
from tatamu.simulation.native.elastic import bending, curvature, membrane, symmetric
from tatamu.simulation.native.options import ElasticOptions
from tests.physics.meshes import LAYOUTS
from tests.scenes import CLOTH

Mesh = tuple[np.ndarray, np.ndarray]
OPTIONS = ElasticOptions()


def regular() -> Mesh:
    vertices, faces = staggered_rectangle(0.6, 0.8, 0.02)
    return vertices, faces


def shuffled() -> Mesh:
    """A mesh with its vertices in no order."""
    vertices, faces = staggered_rectangle(0.2, 0.3, 0.02)
    order = np.random.default_rng(1).permutation(len(vertices))
    return vertices[order], np.argsort(order)[faces]


def irregular() -> Mesh:
    """A mesh without a lattice: nothing fits in bands."""
    plan, faces = LAYOUTS["irregular"](0.2, 0.3, 0.02)
    return np.column_stack([plan, np.zeros(len(plan))]), faces


class Elastic:
    """Membrane and bending of a mesh, through the memory layout of the simulator."""

    def __init__(self, mesh: Mesh, material: Material = CLOTH, fibre: np.ndarray | None = None) -> None:
        self.rest, self.faces = mesh
        self.material = material
        self.topology = Topology(self.faces)
        self.slot, self.slots = slots(self.rest, self.topology.hinges)
        self.triangles = bands(self.slot[self.faces], self.slots)
        hinges = turned_hinges(self.topology.hinges, self.slot)
        self.hinges = bands(self.slot[hinges], self.slots)
        frames = membrane.rest_frames(self.rest, self.faces)
        if material.orthotropic_membrane or material.orthotropic_bending:
            frames = membrane.along_fibres(frames, self.rest, self.faces, fibre)
        self.frames = frames
        self.S, self.L2, self.R = membrane.constants(frames, material)
        free = np.zeros(len(self.topology.hinges), dtype=bool)
        self.curved = curvature.maps(self.rest, self.topology, frames, free, OPTIONS.angle_sum_part)
        self.K = curvature.stiffness(self.curved, curvature.rigidities(material))
        self.at = self.curved.hinges

    def _slotted(self, x: np.ndarray, bands: Bands) -> np.ndarray:
        X = np.zeros((3, self.slots + len(bands.copied)))
        X[:, self.slot] = x.T
        X[:, self.slots :] = X[:, bands.copied]
        return X

    def _gathered(self, F: np.ndarray, bands: Bands) -> np.ndarray:
        np.add.at(F.T, bands.copied, F[:, self.slots :].T)
        return F[:, self.slot].T

    def membrane_force(self, x: np.ndarray) -> np.ndarray:
        X = self._slotted(x, self.triangles)
        F, scratch = np.zeros_like(X), np.zeros(9 * BLOCK)
        compression, crowding = self.material.compression, OPTIONS.crowding_strain
        double = membrane.in_bands(self.triangles, self.S, self.L2, self.R, compression, crowding, np.float64)
        add_force = membrane.add_force_of_wrinkled if double.relaxed.size else membrane.add_force
        add_force(X, F, double, scratch)
        return self._gathered(F, self.triangles)

    def membrane_energy(self, x: np.ndarray) -> float:
        a, b, c = (x[self.faces[:, k]] for k in range(3))
        eps = np.stack([((e) ** 2).sum(1) for e in (c - b, a - c, b - a)]) - self.L2
        return float(0.5 * np.einsum("it,tij,jt", eps, symmetric.unpack(0.5 * self.S), eps))

    def relaxed_energy(self, x: np.ndarray) -> float:
        """Of cloth that wrinkles: from the principal Green strains of every triangle (docs/theory/membrane.md)."""
        corners = x[self.faces]
        now = np.stack([corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]], axis=2)
        then = np.stack([self.frames[:, 1], self.frames[:, 2]], axis=2)
        gradient = now @ np.linalg.inv(then)
        low, high = np.linalg.eigvalsh(0.5 * (gradient.transpose(0, 2, 1) @ gradient - np.eye(2))).T
        cloth, b = self.material, OPTIONS.crowding_strain
        nu, Y = cloth.poisson_ratio, cloth.stretch_stiffness

        def psi(e: np.ndarray, b: float) -> np.ndarray:
            soft = cloth.compression * e**2 + (1 - cloth.compression) * np.minimum(e + b, 0.0) ** 2
            return np.where(e > 0, e**2, soft)

        density = 0.5 * Y * psi(high, b) + 0.5 * Y / (1 - nu**2) * psi(low + nu * high, (1 + nu) * b)
        return float((areas(self.rest, self.faces) * density).sum())

    def _hinge_measures(self, x: np.ndarray) -> np.ndarray:
        """g of every place."""
        measures = bending.scratch(self.hinges.table, self.hinges.size, 0, np.float64)
        bending.measure(self._slotted(x, self.hinges), self.hinges.table, measures)
        return measures.g

    def bending_force(self, x: np.ndarray) -> np.ndarray:
        X = self._slotted(x, self.hinges)
        F = np.zeros_like(X)
        flat = np.zeros(len(self.topology.hinges))
        double = bending.in_bands(self.hinges, self.curved, self.K, flat, self.material, np.float64)
        measures = bending.scratch(double.hinges, self.hinges.size, len(double.coupling_copies), np.float64)
        bending.add_force(X, F, double, measures)
        return self._gathered(F, self.hinges)

    def bending_energy(self, x: np.ndarray) -> float:
        g = self._hinge_measures(x)[self.hinges.place]
        return float(0.5 * np.einsum("tq,tqp,tp", g[self.at], self.K, g[self.at]))


@pytest.fixture(params=[regular, shuffled, irregular], ids=["bands", "shuffled", "copies"])
def elastic(request: pytest.FixtureRequest) -> Elastic:
    return Elastic(request.param())


def check_slopes(
    x: np.ndarray, force: np.ndarray, energy: Callable[[np.ndarray], float], count: int, rel: float
) -> None:
    """Check that a force is minus the slope of an energy, at coordinates drawn at random."""
    rng = np.random.default_rng(1)
    for v, k in zip(rng.integers(0, len(x), count), rng.integers(0, 3, count), strict=True):
        step = np.zeros_like(x)
        step[v, k] = 1e-6
        slope = (energy(x + step) - energy(x - step)) / 2e-6
        assert force[v, k] == pytest.approx(-slope, rel=rel, abs=0.01 * rel * np.abs(force).max())


@pytest.mark.parametrize("part", ["membrane", "bending"])
def test_force_is_minus_the_gradient_of_the_energy(elastic: Elastic, part: str) -> None:
    x = elastic.rest + np.random.default_rng(0).normal(0.0, 0.003, elastic.rest.shape)
    check_slopes(x, getattr(elastic, f"{part}_force")(x), getattr(elastic, f"{part}_energy"), 12, rel=1e-5)


@pytest.mark.parametrize("part", ["membrane", "bending"])
def test_forces_carry_no_momentum(elastic: Elastic, part: str) -> None:
    x = elastic.rest + np.random.default_rng(2).normal(0.0, 0.003, elastic.rest.shape)
    force = getattr(elastic, f"{part}_force")(x)
    scale = np.abs(force).sum()
    assert np.abs(force.sum(0)).max() < 1e-12 * scale
    assert np.abs(np.cross(x, force).sum(0)).max() < 1e-12 * scale


@pytest.mark.parametrize("compression", [0.02, 0.999])
def test_the_force_of_cloth_that_wrinkles_is_minus_the_gradient_of_its_energy(compression: float) -> None:
    elastic = Elastic(regular(), CLOTH.model_copy(update={"compression": compression}))
    noise = np.random.default_rng(3).normal(0.0, 0.003, elastic.rest.shape)  # strains from -0.4 to 0.9: every branch
    x = elastic.rest + noise
    check_slopes(x, elastic.membrane_force(x), elastic.relaxed_energy, 20, rel=1e-4)


def test_cloth_that_hardly_wrinkles_is_cloth_that_does_not() -> None:
    hardly = Elastic(regular(), CLOTH.model_copy(update={"compression": 1.0 - 1e-9}))
    plain = Elastic(regular())
    x = plain.rest + np.random.default_rng(4).normal(0.0, 0.003, plain.rest.shape)
    force = plain.membrane_force(x)
    assert np.allclose(hardly.membrane_force(x), force, atol=1e-7 * np.abs(force).max())


def test_rows_of_a_staggered_mesh_need_no_copies() -> None:
    elastic = Elastic(regular())
    assert len(elastic.triangles.copied) == 0
    assert len(elastic.hinges.copied) == 0
    assert elastic.triangles.size < 1.1 * len(elastic.faces)


def test_uniaxial_stretch_costs_half_y_strain_squared() -> None:
    elastic = Elastic(regular())
    strain, nu = 1e-4, CLOTH.poisson_ratio
    x = elastic.rest * [1 + strain, 1 - nu * strain, 1.0]
    area = 0.6 * 0.8
    assert elastic.membrane_energy(x) == pytest.approx(0.5 * CLOTH.stretch_stiffness * strain**2 * area, rel=1e-3)


@pytest.mark.parametrize(
    ("shape", "curvature", "tolerance"),
    [
        (lambda u, v: u * u / 2, 1.0, 0.05),  # cylinder along the rows
        (lambda u, v: v * v / 2, 1.0, 0.05),
        (lambda u, v: u * v, 2.0, 0.02),  # twist
        (lambda u, v: (u * u + v * v) / 2, 2.0, 0.05),  # sphere
    ],
    ids=["cylinder-x", "cylinder-y", "twist", "sphere"],
)
def test_small_bending_energy_is_that_of_a_plate(shape: object, curvature: float, tolerance: float) -> None:
    elastic = Elastic(regular())
    x = elastic.rest.copy()
    x[:, 2] = 1e-3 * shape(x[:, 0], x[:, 1])  # type: ignore[operator]
    exact = 0.5 * CLOTH.bending_rigidity * curvature * 1e-6 * 0.6 * 0.8
    assert elastic.bending_energy(x) == pytest.approx(exact, rel=tolerance)


@pytest.mark.parametrize("garment", ["tshirt", "trousers"])
def test_garments_lie_in_long_bands(garment: str) -> None:
    """Panels are lattices but for their borders; what fits in no band is computed on copies, at twice the cost."""
    cloth = make_garment(garment)
    topology = Topology(cloth.faces)
    assert cloth.rest is not None
    slot, total = slots(cloth.rest, topology.hinges)
    assert len(np.unique(slot)) == len(slot)
    assert total < 2 * len(slot)
    loose = len(bands(slot[turned(cloth.faces, slot)], total).copied) // 3
    assert loose < 0.12 * len(cloth.faces)


def test_order_of_vertices_and_corners_does_not_matter() -> None:
    vertices, faces = shuffled()
    topology = Topology(faces)
    slot, total = slots(vertices, topology.hinges)
    assert len(bands(slot[turned(faces, slot)], total).copied) == 0
    hinges = turned_hinges(topology.hinges, slot)
    assert len(bands(slot[hinges], total).copied) < 0.1 * hinges.size


def test_unpacking_symmetric_matrices_undoes_packing() -> None:
    matrices = np.random.default_rng(0).normal(size=(5, 3, 3))
    matrices += matrices.transpose(0, 2, 1)
    packed = symmetric.pack(matrices)
    assert packed.shape == (6, 5)
    assert (symmetric.unpack(packed) == matrices).all()
    assert (packed[:, 2] == matrices[2][np.triu_indices(3)]).all()
