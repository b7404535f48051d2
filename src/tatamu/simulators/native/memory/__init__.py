"""Memory layout: vertices on lattices, elements in contiguous bands, and compiled kernels on disk."""
