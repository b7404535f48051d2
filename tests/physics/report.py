"""Functions that run checks, and the report that contains their findings."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from time import perf_counter
from typing import Any

import numpy as np

from tatamu.base.errors import InputError, SimulationError
from tatamu.base.version import __version__
from tests.physics.check import Case, Check
from tests.physics.checks import CHECKS
from tests.physics.findings import Curve, Row
from tests.physics.subject import Subject


@dataclass
class CaseResult:
    """The findings of one case of a check: rows and curves."""

    label: str
    rows: list[Row] = field(default_factory=list)
    curves: list[Curve] = field(default_factory=list)
    seconds: float = 0.0

    @property
    def failed(self) -> bool:
        """Whether the error of any row exceeds its limit."""
        return any(row.passed is False for row in self.rows)


@dataclass
class CheckResult:
    """The findings of one check."""

    check: Check
    cases: list[CaseResult]

    def curves(self, figure: str) -> list[Curve]:
        """Return the curves in one figure of the check."""
        return [curve for case in self.cases for curve in case.curves if curve.figure == figure]


@dataclass
class Report:
    """The findings of all checks of one simulator."""

    simulator: str
    results: list[CheckResult]

    @property
    def rows(self) -> list[Row]:
        """All rows of all checks, which are the measured quantities with their errors."""
        return [row for result in self.results for case in result.cases for row in case.rows]

    @property
    def failures(self) -> int:
        """Number of rows whose error exceeds the limit."""
        return sum(row.passed is False for row in self.rows)

    @property
    def judged(self) -> int:
        """Number of rows with a limit."""
        return sum(row.passed is not None for row in self.rows)

    def to_json(self) -> dict[str, Any]:
        """Return the report as plain data. Numbers that are not finite become null."""
        return {
            "version": 1,
            "tatamu": __version__,
            "simulator": self.simulator,
            "passed": self.failures == 0,
            "judged": self.judged,
            "failures": self.failures,
            "checks": [_check_data(result) for result in self.results],
        }


def _check_data(result: CheckResult) -> dict[str, Any]:
    check = result.check
    cases = [
        {"case": case.label, "seconds": round(case.seconds, 3), "rows": [_row_data(row) for row in case.rows]}
        for case in result.cases
    ]
    return {"name": check.name, "title": check.title, "reference": check.reference, "cases": cases}


def _row_data(row: Row) -> dict[str, Any]:
    numbers = {name: getattr(row, name) for name in ("reference", "got", "error", "limit")}
    plain = {k: float(v) if v is not None and np.isfinite(v) else None for k, v in numbers.items()}
    return {"quantity": row.quantity, **plain, "unit": row.unit, "pass": row.passed, "note": row.note}


def select_cases(names: Iterable[str], quick: bool) -> list[tuple[Check, list[Case]]]:
    """Return the checks with these names, each with its cases to run. Without names, all checks are returned.

    Raises:
        InputError: If no check has one of the names.
    """
    names = list(names)
    for name in names:
        if name not in CHECKS:
            raise InputError(f"--only: must be one of {', '.join(CHECKS)}, given {name!r}")
    checks = [check for name, check in CHECKS.items() if not names or name in names]
    pairs = [(check, [case for case in check.cases if case.quick or not quick]) for check in checks]
    return [(check, cases) for check, cases in pairs if cases]


def validate(
    subject: Subject,
    names: Iterable[str] = (),
    quick: bool = False,
    after: Callable[[CheckResult], None] = lambda result: None,
) -> Report:
    """Run checks on a simulator.

    Args:
        subject: The simulator.
        names: Names of the checks to run; empty for all.
        quick: Whether to omit the long cases.
        after: Called after each check.
    """
    results = []
    for check, cases in select_cases(names, quick):
        results.append(CheckResult(check, [run(case, subject) for case in cases]))
        after(results[-1])
    return Report(subject.name, results)


def run(case: Case, subject: Subject) -> CaseResult:
    """Run one case of a check. If a simulation fails, the result has a failed row."""
    result = CaseResult(case.label)
    started = perf_counter()
    try:
        for finding in case.run(subject):
            (result.rows if isinstance(finding, Row) else result.curves).append(finding)  # type: ignore[arg-type]
    except SimulationError as error:
        result.rows.append(Row("ran to the end", None, np.nan, np.nan, 0.0, "-", str(error)))
    result.seconds = perf_counter() - started
    return result
