"""The pages of a learned fold, of a whole plan and of a garment, and a picture of a fold.

The pages are built on `presentation`, which does not depend on folds. Each page collects its data from the modules of
this package: `headline`, `tables`, `measures` (the measures and their thresholds), `topview`, `errormap`, `histogram`,
`search`, `paths`, `replay`, `command`. These read a `fold`. `still` draws a picture without a browser;
`notebook` shows a fold within another page.
"""

from __future__ import annotations

from tatamu.report.notebook import embedded
from tatamu.report.page import write_report
from tatamu.report.plan import write_plan_report
from tatamu.report.still import picture

__all__ = ["embedded", "picture", "write_plan_report", "write_report"]
