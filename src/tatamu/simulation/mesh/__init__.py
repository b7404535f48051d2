"""Triangle meshes: making them, their edges and neighbours, and where they cross or cover pixels.

Points have the shape (n, 2) or (n, 3), triangles (m, 3) and edges (e, 2).
"""
