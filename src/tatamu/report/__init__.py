"""The report of a learned fold, and of a whole plan: one page that opens offline, and a picture.

Imports point one way: `page` and `still` (a picture) call the figures, tables and the replay; those read a
`fold`, which is made of `records`; pictures stand on `shading`, `raster` and `png`.
"""

from __future__ import annotations

from tatamu.report.page import write_report
from tatamu.report.plan import write_plan_report
from tatamu.report.still import picture

__all__ = ["picture", "write_plan_report", "write_report"]
