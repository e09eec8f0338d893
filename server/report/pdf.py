"""The page of a report as PDF, by WeasyPrint, which needs the Pango library of the system."""

from __future__ import annotations

from mapper.core.errors import ConfigError


def report_pdf(page: str) -> bytes:
    """Return the page of :func:`server.report.page.report_page` as a PDF of A4 pages.

    Nothing is fetched for it. Raises :class:`ConfigError` where WeasyPrint or Pango is not installed.
    """
    try:
        from weasyprint import HTML  # noqa: PLC0415 - loads Pango, which may be missing
        from weasyprint.urls import URLFetcher  # noqa: PLC0415 - as above
    except (ImportError, OSError):
        raise ConfigError(
            "report.no_pdf",
            "PDF needs WeasyPrint (pip install 'gridbloom[pdf]') and the library Pango (libpango-1.0-0, "
            "libpangoft2-1.0-0); a browser prints the report as HTML to PDF too.",
        ) from None
    document = HTML(string=page, url_fetcher=URLFetcher(allowed_protocols=("data",)))
    return bytes(document.write_pdf())
