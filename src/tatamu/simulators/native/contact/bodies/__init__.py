"""Contact of cloth with rigid bodies: by how much does a moving body push the cloth, and how far does it drag it along?

Every body is a *rounded box*: a core (a box with half sizes h; a segment or a point if some of these are zero) and
everything within a radius of it. A sphere is a rounded point, a capsule a rounded segment, so one signed distance
serves all shapes:

    q = |p| - h,   d(p) = |max(q, 0)| + min(max(q_x, q_y, q_z), 0) - r        p in the body's frame

The distance is convex. The point of a triangle that is nearest to a body is therefore a vertex, a point inside an edge,
or a point inside the face. These are tested separately:

    vertex   d at the vertex
    edge     the minimum of d along the edge, by bisection of its derivative
    face     a corner of the core over the inside of the triangle: the normal of the triangle then lies in the corner's
             normal cone, and the corner is on the side of the triangle's plane on which it was

The mid-surface of the cloth stays half a thickness from the body. A pair that is closer is pushed apart along the
normal n, shared by inverse masses (the body has none); the tangential part is Coulomb friction against the moving
surface. Slip is measured in the frame of the body, from where the cloth was at the start of the round to where it is,
so that a body that moves or turns carries the cloth along:

    s = R1' (x - c1) - R0' (x0 - c0),   s_t = s - (n s) n,   s_t shrinks by min(1, mu push / |s_t|)

As everywhere in contact, the side of a body on which cloth lies is that at the legal start of the round. A point has
passed through the body if its path is longer than its distance and its new normal points against the old one. Its
distance is then measured from the tangent plane of the earlier side.

    state        the bodies as arrays: shapes, paths, poses of the round, candidates
    rounded_box  the distance and its normal, and its minimum along an edge
    near         candidates: wide ones, kept until something may have come near, and narrow ones of each round
    push         the gap of a point of the cloth, and its correction
    sweep        all vertices, edges and faces near each body

Bodies are resolved after every membrane step, and again in each sweep of contact. No state is carried from round to
round except the candidates, on which nothing depends as long as they are complete.
"""
