"""The kernels that the time steps call by their addresses, and the features of a scene that need them."""

from __future__ import annotations

from typing import Any, NamedTuple

from tatamu.simulation.native import air, among_bodies
from tatamu.simulation.native.addresses import Addresses
from tatamu.simulation.native.compiled import address_of
from tatamu.simulation.native.contact import (
    broad_phase,
    edge_edge,
    edge_edge_search,
    impact_zones,
    table,
    vertex_face,
    vertex_face_search,
)
from tatamu.simulation.native.contact.bodies import sweep as rigid
from tatamu.simulation.native.contact.bodies.state import place
from tatamu.simulation.native.elastic import bending, membrane
from tatamu.simulation.native.system import System


class Features(NamedTuple):
    """What a scene has beside elastic cloth on a table."""

    friction: bool
    """Whether bending has friction."""
    wrinkles: bool
    """Whether cloth resists compression less than tension."""
    air: bool
    """Whether air acts by direction."""
    bodies: bool

    @classmethod
    def of(cls, system: System) -> Features:
        """Return the features of a scene."""
        return cls(
            friction=len(system.elastic.bending.friction.area) > 0,
            wrinkles=system.elastic.membrane.relaxed.shape[1] > 0,
            air=system.air.directional,
            bodies=len(system.bodies.radius) > 0,
        )


def kernels(features: Features) -> dict[str, Any]:
    """Return the kernels that scenes with these features need, by their field of `Addresses`."""
    needed = {
        "search_partners": vertex_face_search.search,
        "search_edges": edge_edge_search.search,
        "order_by_height": broad_phase.order_by_height,
        "sweep_edges": edge_edge.sweep,
        "sweep_vertices": vertex_face.sweep,
        "sweep_table": table.sweep,
        "hold_zones": impact_zones.hold,
        "bend": bending.add_force_with_friction if features.friction else bending.add_force,
        "stretch": membrane.add_force_of_wrinkled if features.wrinkles else membrane.add_force,
        "largest_stretch": membrane.largest_stretch,
    }
    if features.air:
        needed |= {"meet_air": air.meet, "resist_air": air.resist}
    if features.bodies:
        needed |= {
            "place_bodies": place,
            "near_bodies": among_bodies.find_near,
            "meet_bodies": among_bodies.meet,
            "sweep_bodies": rigid.sweep,
        }
    return needed


def arguments(system: System) -> dict[str, tuple[Any, ...]]:
    """Return arguments of the types with which the time steps call each kernel, by its field of `Addresses`."""
    state = system.state
    elastic = system.elastic
    x = state.positions.x
    number, part = 0, 0.0
    contact = (state.positions, system.mesh, system.contact, system.options)
    surface = (state.V, state.surface, system.air, state.positions)
    return {
        "search_partners": (x, system.mesh, system.contact.vertex_face, system.options),
        "search_edges": (x, *contact[1:]),
        "order_by_height": (x, system.contact),
        "sweep_edges": (*contact, part, part),
        "sweep_vertices": (*contact, part, part),
        "sweep_table": (state.positions, system.mesh.inverse_mass, system.contact, system.plane, system.options, part),
        "hold_zones": contact,
        "bend": (state.Y, state.F, elastic.bending, state.hinges),
        "stretch": (state.Y, state.F, elastic.membrane, state.triangle_forces),
        "largest_stretch": (state.X, elastic.membrane),
        "meet_air": (*surface, system.mesh.faces, state.slot, state.free, part),
        "resist_air": (state.V, state.F, state.inverse_mass, state.surface, part, part, part),
        "place_bodies": (system.bodies, number, part, part),
        "near_bodies": (system, number, number, number, number),
        "meet_bodies": (system, number, number, number),
        "sweep_bodies": (*contact[:3], system.bodies, system.options, part, part),
    }


def addresses(system: System) -> Addresses:
    """Return the addresses of the kernels that a scene needs. Kernels are compiled if necessary."""
    needed = kernels(Features.of(system))
    given = arguments(system)
    return Addresses(*(address_of(needed[name], given[name]) if name in needed else 0 for name in Addresses._fields))
