"""Addresses of the kernels that the time steps call, see `compiled.call`."""

from __future__ import annotations

from typing import NamedTuple


class Addresses(NamedTuple):
    """Addresses of kernels in memory; 0 for a kernel that the scene does not need."""

    bend: int
    """`bending.add_force` or `bending.add_force_with_friction`."""
    stretch: int
    """`membrane.add_force` or `membrane.add_force_of_wrinkled`."""
    largest_stretch: int
    sweep_edges: int
    sweep_vertices: int
    sweep_table: int
    hold_zones: int
    search_partners: int
    search_edges: int
    order_by_height: int
    meet_air: int
    resist_air: int
    place_bodies: int
    near_bodies: int
    meet_bodies: int
    sweep_bodies: int


NONE = Addresses(*[0] * len(Addresses._fields))
