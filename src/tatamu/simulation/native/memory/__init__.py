"""The layout of vertices and elements in memory, with which loops are fast."""
