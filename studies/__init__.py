"""Research studies with tatamu. They are not part of the package, and are run from the root of the repository.

- `real_cloth` compares published measurements of real cloth with predictions of a simulator.
- `paper` repeats section VI of the paper that tatamu's method comes from, with its figures, tables and claims.

`python -m studies.NAME --help` shows the options of a study. `benchmarks.tables` writes the tables into the docs.
"""
