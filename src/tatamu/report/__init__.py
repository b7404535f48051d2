"""The report of a learned fold: one page that opens offline, and a picture.

    report, picture                      what is called from outside
      page ── tables, figures, replay    what the page is put together from
        fold ── records                  the result folder, read and checked
        raster ── png                    pictures without a browser
"""

from __future__ import annotations

from tatamu.report.page import write_report
from tatamu.report.still import picture

__all__ = ["picture", "write_report"]
