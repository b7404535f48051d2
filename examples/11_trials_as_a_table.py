"""Read the trials of a study as columns, for pandas if it is installed.

python examples/11_trials_as_a_table.py
"""

from __future__ import annotations

from importlib.util import find_spec

import tatamu as tt


def main() -> int:
    """Return how many trials the table has."""
    task = tt.make_task("towel", size=(0.24, 0.5), spacing=0.04)
    options = tt.LearnOptions(trials=6, disturbances="none", baselines=False)
    result = tt.learn(task, options)
    columns = result.table()
    if find_spec("pandas"):
        import pandas

        print(pandas.DataFrame(columns).sort_values("minimised").to_string())
    else:
        for row in zip(columns["number"], columns["minimised"], columns["mean_vertex_distance"], strict=True):
            print("trial {}: objective {}, mean vertex distance {} m".format(*row))
    return len(columns["number"])


if __name__ == "__main__":
    main()
