"""Real cloth: measurements that others published, beside what a simulator predicts.

A test reads its file from a folder that the user names (the data are not part of tatamu), simulates what was measured,
and makes a section: tables, charts and drawings, with the number to beat and with what the test cannot show.
docs/notes/real-cloth.md has the results and says where the data are from.

- `fabric`: what the measurements lack of a fabric, from typical ones, each with its source;
- `matsudaira`, `leeds`, `motion`, `towel`: the tests; `registry` lists them;
- `bench`: simulates, and keeps what it read in a folder, so that a killed run goes on;
- `section`: what a test hands over; `notes` and `page` show it.
"""
