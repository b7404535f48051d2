"""Compares published measurements of real cloth with predictions of a simulator.

A test reads the measurements from a file and simulates the experiment. The user names the folder of the files, because
the data are not part of tatamu. The result of a test is a section with tables, charts and drawings. A section also has
the best published number, and the limits of the test. The page docs/notes/real-cloth.md shows the results, and
docs/guide/studies.md lists the sources of the data.

- `matsudaira`, `leeds`, `motion` and `towel` are the tests, and `registry` lists them.
- `fabric` has typical values of properties that were not measured, each with its source.
- `bench` simulates experiments, and keeps the values that were read from them in a folder, so an interrupted run can be
  resumed.
- `section` defines the result of a test, and `notes` and `page` show it.
"""
