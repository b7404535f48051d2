"""Contact of cloth with itself, with the table and with rigid bodies (docs/theory/contact.md).

Elastic forces, gravity and hands give a predicted position of every vertex for the end of a time step. Contact corrects
these positions, so that no layer passes through another, layers stay a thickness apart, and friction acts. The
corrections, divided by the time step, become velocity. The positions at the start of the step are *legal*: every vertex
is on the correct side of its neighbours, because contact corrected them in the step before.

The algorithm is position-based dynamics (Mueller et al. 2007) with stages of robust cloth collision (Bridson, Fedkiw
and Anderson 2002): proximity, repulsion and friction. Rigid impact zones (Provot 1997) are the last resort. Instead of
continuous collision detection, each candidate (a pair of mesh elements that may touch) remembers on which side of each
other its elements were at the start of the step. A pair that has passed through has a negative gap, and is pushed back.

The search finds candidates up to one thickness plus the *margin*. Three kinds of pairs are not kept apart:

- two edges in flat cloth that is not pressed,
- a vertex and a triangle that is not one of the three partners of the vertex,
- two edges that were farther apart at the last search than one thickness plus half of the margin.

The command `make tangle` counts how often cloth passes through cloth. A round of contact is one call of
`gauss_seidel.resolve`, which uses the modules in this order:

    motion           `motion.follow`            adds up the path of each vertex; a distant pair sleeps (is not tested)
                                                until its paths are long enough
    broad phase      `broad_phase.refresh`      searches candidates again, but only if two parts of the cloth may have
                                                come closer by the margin since the last search
                       `vertex_face_search`     finds the *partners* of a vertex: the nearest triangles below and above
                                                it, and a third triangle that it touches
                       `edge_edge_search`       pairs guarded edges (borders, creases, pressed layers) with edges near
                       `grid`, `shape`          sorts triangles into a uniform grid; computes normals and radii
    sweeps           are repeated, until each pair has the distance that the next sweep would restore
                       `edge_edge.sweep`        measures and corrects pairs of edges
                       `vertex_face.sweep`      corrects vertices, from the highest down, with Coulomb friction
                       `bodies.sweep`           corrects vertices, edges and faces near rigid bodies (also after every
                                                membrane step)
                       `table.sweep`            is last, because the layers pass their load on to the table
                       `projection`             computes how far a pair is pushed, and how much becomes velocity
    last resort      `impact_zones.hold`        sets pairs back that still pass through, and moves them as one
    pace             `rounds_of_next_step`      makes several rounds per outer (longest) time step for crushed layers

When a hand opens, `untangle` separates layers that it has forced through one another.

tests/test_native_contact.py, test_native_vertex_face.py and test_native_edge_edge.py test these invariants:

1. Legal positions determine on which side a vertex is, and predicted positions never do.
2. A partner moves to a neighbouring triangle as the cloth slides, but never around a fold whose halves lie back to
   back, and never onto another partner. Otherwise, only a search changes the partners.
3. A sleeping pair is tested again when the paths of its vertices show that its elements may be near each other.
4. If hands hold vertices of both elements of a pair, the pair is never corrected.
5. Corrections are distributed by inverse masses, so they change no momentum. If a pair was too close at the start of
   the step, its correction adds at most the recovery speed to the velocities.
6. Two rollouts of the same scene have the same bytes.

The modules write these fields of `state.ContactState`, where "sleep" stands for `wake`, `meets` and `awake`:

    record            search                 sweeps                               impact zones
    vertex_face       partners, side, order  triangle, side, anchors, sleep       -
    edge_edge         pairs, guarded         sleep, apart                         -
    activity          pressed (counts down)  touched, restless, pressed           restless
    motion            all, by `motion`       -                                    -
    counters          ordered, pairs, ..     newly_pressed, pairs awake           -

Read the modules in this order: `state`, `projection`, `vertex_face`, `edge_edge`, `gauss_seidel`, then the rest.
"""
