"""The report on a log: one page that needs no server, to be read or printed.

Each name is imported from its module on first use, so that a service starts without the modules that examine logs.
"""

from typing import TYPE_CHECKING

from mapper.core.lazy_imports import imported_later

if TYPE_CHECKING:
    from server.report.content import Picture, PlacedNote, Report, make_report
    from server.report.page import report_page
    from server.report.pdf import report_pdf

__all__ = ["Picture", "PlacedNote", "Report", "make_report", "report_page", "report_pdf"]

__getattr__ = imported_later(__name__, __file__)
