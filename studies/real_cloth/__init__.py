"""Published measurements of real cloth, compared with predictions of a simulator.

A test reads its file from a folder that the user names (the data are not part of tatamu) and simulates the experiment.
Its section has tables, charts and drawings, the number to beat, and the limits of the test. docs/notes/real-cloth.md
has the results and says where the data are from.

- `fabric`: properties of a fabric that were not measured, from typical fabrics, each with its source;
- `matsudaira`, `leeds`, `motion`, `towel`: the tests; `registry` lists them;
- `bench`: simulates and keeps the readings in a folder, so that a killed run can be resumed;
- `section`: the result of a test; `notes` and `page` show it.
"""
