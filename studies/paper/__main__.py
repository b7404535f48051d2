"""Section VI of the paper once more: docs/guide/reproduction.md.

python -m studies.paper --garments towel --seeds 1 --out runs/paper
python -m studies.paper --simulator native --out runs/paper-native
"""

from __future__ import annotations

import typer

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
