"""Research with tatamu, which is not part of the package; run from the root of the repository.

- `real_cloth`: published measurements of real cloth compared with predictions of a simulator;
- `paper`: section VI of the paper repeated, with its figures, tables and claims;
- `search`: the default search compared with others;
- `cluster_storm`: a cluster whose workers, database and client are killed; its overhead; 1,000 workers;
- `readers`: random docstrings and pages for the readers' test.

`python -m studies.NAME --help` shows the options of a study. Tables go to the docs by way of `benchmarks.tables`.
"""
