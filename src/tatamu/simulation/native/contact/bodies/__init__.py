"""Contact of cloth with rigid bodies. A body pushes the cloth out of the way, and drags the cloth along by friction.

Every body is a *rounded box*: a core, and everything within a radius r of the core. The core is a box with the half
sizes h. If some half sizes are zero, the core is a rectangle, a segment or a point. A sphere is a rounded point, and a
capsule is a rounded segment. Therefore one formula gives the signed distance d of a point p (in the frame of the body)
from any of these shapes:

    q = |p| - h,   d(p) = |max(q, 0)| + min(max(q_x, q_y, q_z), 0) - r

In q, the absolute value of each coordinate is taken. |max(q, 0)| is the length of a vector.

The distance is a convex function of the point. The point of a triangle that is nearest to a body is a vertex, a point
inside an edge, or a point inside the face. These three cases are tested separately:

    vertex   d at the vertex
    edge     the minimum of d along the edge, by bisection of its derivative
    face     the distance of a corner of the core from the triangle's plane, minus r, if the corner lies over the inside
             of the triangle, and the triangle's normal lies in the normal cone of the corner

The normal cone of a corner contains the directions in which the corner is the farthest point of the core. The distance
is measured on the side of the triangle's plane on which the corner was at the start of the round.

The mid-surface of the cloth stays half a thickness from the body. A vertex, edge or face that is closer is pushed out
along the normal n. The push is distributed over its vertices by their inverse masses. The body does not give way.
Coulomb friction with the coefficient mu acts along the surface of the body. A round is one call of contact, in which
all pairs are corrected. The slip s leads from the position x0 of the cloth at the start of the round to its position x.
It is measured in the frame of the body, so a body that moves or turns carries the cloth along. The rotation and the
centre of the body are R0 and c0 at the start of the round, and R1 and c1 at its end. A prime marks the transpose of a
matrix:

    s = R1' (x - c1) - R0' (x0 - c0),   s_t = s - (n s) n,   s_t shrinks by min(1, mu push / |s_t|)

s_t is the part of the slip along the surface. Friction removes the fraction min(1, mu push / |s_t|) of s_t, where push
is the length of the push.

Cloth stays on the side of a body on which it is at the start of the round. A point counts as passed through the body
under two conditions. Its path in the round is longer than the sum of its distances at both ends of the path, and the
normals at both ends point in opposite directions. The distance of such a point is measured from the tangent plane of
the body on the side from which the point came.

    state        the bodies as arrays: shapes, paths, poses of the round, candidates
    rounded_box  the distance and its normal, and its minimum along an edge
    near         wide candidates, kept until other parts may have come near, and narrow candidates of each round
    push         the gap between a point of the cloth and a body, and its correction
    sweep        correction of all vertices, edges and faces near each body

Contact with bodies is resolved after every membrane step, the shortest time step, and again in each sweep of contact.
Only the candidates are kept from one round to the next. The candidates do not influence the result as long as they are
complete.
"""
