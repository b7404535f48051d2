"""Where data lie: vertices on lattices, elements in bands, compiled kernels on disk. Knows nobody above."""
