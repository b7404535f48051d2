"""Contact of cloth with rigid bodies, which push cloth out of the way and drag it along (docs/theory/contact.md).

Every body is a *rounded box* (`tatamu.simulation.body`) with a core, a radius r and a convex signed distance d. The
point of a triangle that is nearest to a body is therefore a vertex, or inside an edge or the face, each tested apart:

    vertex   d at the vertex
    edge     the minimum of d along the edge, by bisection of its derivative
    face     the distance of a corner of the core from the triangle's plane, minus r, if the corner lies over the inside
             of the triangle, and the triangle's normal lies in the normal cone of the corner

The normal cone of a corner contains the directions in which the corner is the farthest point of the core. The distance
is measured on the side of the triangle's plane on which the corner was at the start of the round.

What is closer than half a thickness is pushed out along the normal n, distributed over vertices by their inverse
masses. Friction acts on the slip s in the frame of the body, so a body that moves or turns carries the cloth along.
With the position x of the cloth, and the rotation R and centre c of the body, at the start (0) and the end (1) of the
round:

    s = R1' (x - c1) - R0' (x0 - c0),   s_t = s - (n s) n,   s_t shrinks by min(1, mu push / |s_t|)

A point has passed through the body if its path in the round is longer than the sum of its distances at both ends, and
the normals there are opposite. Its distance is measured from the tangent plane on the side from which it came.

    state        the bodies as arrays: shapes, paths, poses of the round, candidates
    rounded_box  the distance and its normal, and its minimum along an edge
    near         wide candidates, kept until other parts may have come near, and narrow candidates of each round
    push         the gap between a point of the cloth and a body, and its correction
    sweep        correction of all vertices, edges and faces near each body

Contact with bodies is resolved after every membrane step, the shortest time step, and again in each sweep of contact.
Only candidates are kept from one round to the next, which do not influence the result as long as they are complete.
"""
