"""The page of a report as PDF, by WeasyPrint, which needs the Pango library of the system.

It runs in its own process, because WeasyPrint makes Pillow accept truncated images everywhere in its process, and its
computation would block the threads of a service. As a program it writes the PDF of the page on standard input.
"""

from __future__ import annotations

import subprocess
import sys

from mapper.core.errors import ConfigError

PATIENCE_S = 120.0
MISSING = 3  #: exit status if WeasyPrint or Pango is not installed


def report_pdf(page: str) -> bytes:
    """Return the page of :func:`server.report.page.report_page` as a PDF of A4 pages.

    Nothing is downloaded for it. Raises :class:`ConfigError` if WeasyPrint or Pango is not installed, and if the PDF is
    not finished within two minutes.
    """
    program = [sys.executable, "-c", "from server.report.pdf import main; main()"]
    try:
        done = subprocess.run(  # noqa: S603 - this program
            program, input=page.encode(), capture_output=True, timeout=PATIENCE_S, check=False
        )
    except subprocess.TimeoutExpired:
        raise ConfigError("report.pdf_failed", f"The PDF was not made within {PATIENCE_S:g} s.") from None
    if done.returncode == MISSING:
        raise ConfigError(
            "report.no_pdf",
            "PDF needs WeasyPrint (pip install 'gridbloom[pdf]') and the library Pango (libpango-1.0-0, "
            "libpangoft2-1.0-0); a browser prints the report as HTML to PDF too.",
        )
    if done.returncode != 0:
        raise ConfigError("report.pdf_failed", "The PDF could not be made; a browser prints the report to PDF too.")
    return done.stdout


def main() -> None:
    """Write the PDF of the page on standard input to standard output."""
    try:
        from weasyprint import HTML  # noqa: PLC0415 - loads Pango, which may be missing
        from weasyprint.urls import URLFetcher  # noqa: PLC0415 - as above
    except (ImportError, OSError):
        raise SystemExit(MISSING) from None
    document = HTML(string=sys.stdin.buffer.read().decode(), url_fetcher=URLFetcher(allowed_protocols=("data",)))
    sys.stdout.buffer.write(document.write_pdf())
