"""Makes HTML pages about a learned fold, a plan of several folds, or a garment. Also makes pictures of folds.

They are built with `show`, which does not know folds. `still` draws a picture of a fold without a browser, and
`embedded` shows a fold inside another page.
"""

from __future__ import annotations

from tatamu.report.page import embedded, write_report
from tatamu.report.plan import write_plan_report
from tatamu.report.still import picture

__all__ = ["embedded", "picture", "write_plan_report", "write_report"]
