"""Tables of docs/notes/real-cloth.md: what native predicts of measured real cloth.

    python benchmarks/real_cloth.py --data DATA --out runs/real-cloth [--only drape] [--write-docs]

DATA is the folder with the measurements that docs/notes/real-cloth.md lists. Writes what
`tatamu validate --real DATA --out DIR` writes.
"""

from __future__ import annotations

import argparse
from pathlib import Path

from tables import publish

from tatamu.files import write_json, write_text
from tatamu.validation.real import notes
from tatamu.validation.real.bench import Bench
from tatamu.validation.real.page import page
from tatamu.validation.real.study import load, run

SIMULATOR = "native"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--data", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--only", action="append", default=[], metavar="TEST")
    parser.add_argument("--write-docs", action="store_true", help="write the tables into docs/notes/real-cloth.md")
    options = parser.parse_args()
    bench = Bench(SIMULATOR, options.out / "kept", tick=lambda label: print(label, flush=True))
    sections = run(load(options.data, options.only), bench)
    write_json(options.out / "real-cloth.json", notes.data(sections, SIMULATOR))
    write_text(options.out / "real-cloth.md", notes.page(sections, SIMULATOR))
    write_text(options.out / "real-cloth.html", page(sections, SIMULATOR))
    for section in sections:
        print(f"{section.title}: {section.goal}")
        if options.write_docs:
            publish(f"real: {section.name}", notes.text(section))


if __name__ == "__main__":
    main()
