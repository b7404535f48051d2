"""Contact of cloth with itself and with the table, in positions.

Contact takes the positions that elastic forces, gravity and hands predict for the end of a time step, and moves them so
that no layer passes through another, that layers stay a thickness apart, and that friction acts. Its changes of
positions become velocity. The start of the step, where contact left the cloth before, is *legal*: every vertex is on
the correct side of its neighbours.

The algorithm is that of position-based dynamics (Mueller et al. 2007) with the layers of robust cloth collision around
it (Bridson, Fedkiw and Anderson 2002): proximity, repulsion, friction, and rigid impact zones (Provot 1997) as last
resort. It has no continuous collision detection, the middle layer of Bridson et al. Instead, candidates remember their
side at the start of the step. A pair that has passed through within a step has a negative gap, and is pushed back.
Three kinds of pairs are not guarded: flat edges that are not pressed, sheets beyond the three partners of a vertex, and
edges that approach from beyond half of the margin. `make tangle` counts how often anything passes through. One round of
contact is `gauss_seidel.resolve`:

    motion           `motion.follow`            paths of the vertices grow, by which pairs that are apart sleep
    broad phase      `broad_phase.refresh`      candidates are searched again only when two parts of the cloth may have
                                                come closer by the margin since the last search:
                       `vertex_face_search`     per vertex the nearest triangle below and above it, and one that it
                                                touches and would lose to these: at most three *partners*
                       `edge_edge_search`       pairs of guarded edges (borders, creases, pressed layers) and edges near
                       `grid`, `shape`          triangles by their centroids in a uniform grid; normals and radii
    sweeps           one after the other, each only while some pair lacks what it would restore:
                       `edge_edge.sweep`        narrow phase and correction of edge pairs
                       `vertex_face.sweep`      of vertices, from the highest down; Coulomb friction with anchors
                       `bodies.sweep`           of vertices, edges and faces near rigid bodies; also made after every
                                                membrane step
                       `table.sweep`            last, so that it carries what the layers hand down
                       `projection`             how far a pair is pushed, what of it becomes velocity (split impulse)
    last resort      `impact_zones.hold`        what has passed nevertheless is set back, and moves as one
    pace             `rounds_of_next_step`      crushed layers are resolved several times per outer step

Apart from that, `untangle` takes apart layers that a closed hand has forced through one another when it opens: by the
curve along which they meet, without any memory of sides (Volino and Magnenat-Thalmann 2006). What it leaves may still
be tangled, and is tried again.

Invariants, held by tests/test_native_contact.py, test_native_vertex_face.py and test_native_edge_edge.py:

1. Legal positions, those at the start of a step, decide on which side something is, never predicted ones. 2. A partner
follows the cloth from triangle to neighbouring triangle, but neither around a fold that lies back to back nor onto
another partner; only a search changes it otherwise. 3. A pair sleeps only until the paths of its own vertices
(`motion`) show that it may be near. 4. A pair that hands hold on both sides is never corrected. 5. The correction of a
pair is distributed by inverse masses, so it changes no momentum. If the pair was too close at the start of the step, at
most the recovery speed becomes velocity. 6. Everything depends only on the input: a rollout always has the same bytes.

Who writes what of `state.ContactState`:

    record            search                 sweeps                               impact zones
    vertex_face       partners, side, order  triangle, side, anchors, sleep       -
    edge_edge         pairs, guarded         sleep                                -
    activity          pressed (counts down)  touched, restless, pressed           restless
    motion            all, by `motion`       -                                    -
    counters          ordered, pairs, ..     newly_pressed, pairs awake           -

Sleep is `wake`, `meets` and `awake`. `gauss_seidel` counts sweeps; `motion` adds up paths at the start of every round;
the time step counts outer steps and sets the rounds of each.

Read them in this order: `state`, `projection`, `vertex_face`, `edge_edge`, `gauss_seidel`, then the rest.
"""
