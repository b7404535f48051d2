"""Memory layout: vertices on lattices, elements in bands, compiled kernels on disk."""
