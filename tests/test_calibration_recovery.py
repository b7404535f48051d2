"""Hidden materials come back, and the stated intervals are honest: a part of `make calibration`, minutes long."""

from __future__ import annotations

import importlib
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import binom


@pytest.mark.slow
def test_hidden_materials_come_back_with_honest_intervals(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.syspath_prepend(str(Path(__file__).parent.parent))
    module = importlib.import_module("benchmarks.calibration")
    rows = module.recovery(tmp_path, draws=6, repeats=4)
    covers = []
    for name, limit in module.LIMITS.items():
        told = [row["rounded"][name] for row in rows if row["rounded"][name]["stated"] <= limit / 2]
        assert told and all(abs(each["error"]) <= limit for each in told if each["known"]), name
        covers += [each[name]["covers"] for row in rows for each in row["noisy"] if each[name]["known"]]
    low, high = binom.interval(0.99, len(covers), 0.6827)  # honest intervals fail this once in a hundred seeds
    assert low <= np.sum(covers) <= high
