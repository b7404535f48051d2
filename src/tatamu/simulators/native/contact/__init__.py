"""Contact of cloth with itself and with the table, in positions.

Elastic forces, gravity and hands predict positions for the end of a time step. Contact moves these positions. As a
result, no layer passes through another, layers stay a thickness apart, and friction acts. The changes of positions
become velocity. The positions at the start of the step are *legal*, which means that every vertex is on the correct
side of its neighbours. They are legal because contact corrected them in the step before.

The algorithm is position-based dynamics (Mueller et al. 2007). It has some of the stages of robust cloth collision
(Bridson, Fedkiw and Anderson 2002): proximity, repulsion and friction. Rigid impact zones (Provot 1997) are the last
resort. Bridson et al. also have a stage of continuous collision detection, which is absent here. Instead, each
candidate (a pair of mesh elements that may touch) remembers its side at the start of the step. A pair that has passed
through within a step has a negative gap, and is pushed back.

Three kinds of pairs are not guarded against passing through:

- flat edges that are not pressed,
- a vertex and a sheet that is not among the three partners of the vertex,
- edges that come from farther away than half of the margin.

The command `make tangle` counts how often anything passes through. A round of contact is one call of
`gauss_seidel.resolve`. This call uses the modules in this order:

    motion           `motion.follow`            updates the paths of the vertices, which tell which pairs can sleep
    broad phase      `broad_phase.refresh`      searches candidates again, but only if two parts of the cloth may have
                                                come closer by the margin since the last search
                       `vertex_face_search`     per vertex the nearest triangle below and above it, and one more that
                                                it touches: at most three *partners*
                       `edge_edge_search`       pairs of guarded edges (borders, creases, pressed layers) and edges near
                       `grid`, `shape`          triangles by their centroids in a uniform grid; normals and radii
    sweeps           follow one another, until each pair has the distance that the next sweep would restore
                       `edge_edge.sweep`        narrow phase and correction of edge pairs
                       `vertex_face.sweep`      of vertices, from the highest down; Coulomb friction with anchors
                       `bodies.sweep`           of vertices, edges and faces near rigid bodies; also made after every
                                                membrane step
                       `table.sweep`            last, because the layers pass their load on to the table
                       `projection`             how far a pair is pushed, what of it becomes velocity (split impulse)
    last resort      `impact_zones.hold`        pairs that still pass through are set back, and move as one
    pace             `rounds_of_next_step`      crushed layers are resolved several times per outer (longest) time step

A separate module, `untangle`, takes layers apart that a closed hand has forced through one another. It does so when the
hand opens. It uses the curve along which the layers meet, and no memory of sides (Volino and Magnenat-Thalmann 2006).
If layers are still tangled afterwards, `untangle` tries again.

tests/test_native_contact.py, test_native_vertex_face.py and test_native_edge_edge.py test these invariants:

1. The legal positions at the start of a step determine on which side a vertex is. Predicted positions never do.
2. A partner (a triangle from which a vertex is kept) moves from triangle to neighbouring triangle as the cloth slides.
   It does not move around a fold that lies back to back, and not onto another partner. Otherwise only a search changes
   it.
3. A sleeping pair is not tested. It wakes when the paths of its own vertices (`motion`) show that it may be near.
4. A pair that hands hold on both sides is never corrected.
5. The correction of a pair is distributed by inverse masses, so it changes no momentum. If the pair was too close at
   the start of the step, at most the recovery speed becomes velocity.
6. Everything depends only on the input: a rollout always has the same bytes.

This table lists the module that writes each field of `state.ContactState`:

    record            search                 sweeps                               impact zones
    vertex_face       partners, side, order  triangle, side, anchors, sleep       -
    edge_edge         pairs, guarded         sleep                                -
    activity          pressed (counts down)  touched, restless, pressed           restless
    motion            all, by `motion`       -                                    -
    counters          ordered, pairs, ..     newly_pressed, pairs awake           -

The fields `wake`, `meets` and `awake` are listed as sleep. `gauss_seidel` counts sweeps. `motion` adds up paths at the
start of every round. The time step counts outer steps and sets the number of rounds in each.

Read the modules in this order: `state`, `projection`, `vertex_face`, `edge_edge`, `gauss_seidel`, then the rest.
"""
