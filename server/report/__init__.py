"""The report on a log for whoever asked for it: one page that needs no server, to be read or printed."""

from server.report.content import Picture, PlacedNote, Report, make_report
from server.report.page import report_page

__all__ = ["Picture", "PlacedNote", "Report", "make_report", "report_page"]
