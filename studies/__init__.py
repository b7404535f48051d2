"""Research with tatamu, which is not part of the package; run from the root of the repository.

- `real_cloth`: published measurements of real cloth beside what a simulator predicts;
- `paper`: section VI of the paper once more, with its figures, tables and claims;
- `search`: the search beside its alternatives;
- `cluster_storm`: workers, database and client killed; overhead; what 1,000 workers would need.

`python -m studies.NAME --help` shows the options of a study. Tables go to the docs by way of `benchmarks.tables`.
"""
