"""Triangle meshes: making them, their edges and neighbours, and where they cross or cover pixels."""
