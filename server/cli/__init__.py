"""The ``gridbloom`` command.

``serve`` runs the service, ``upload`` sends a log to one, ``notes`` downloads the notes on it; all other commands work
on files. Bad input is reported in one sentence on standard error, with exit status 2. A log that exceeds the limits of
``check`` has exit status 1. With ``--json``, standard output is one JSON object and nothing else.
"""

from __future__ import annotations

from server.cli.commands import app

__all__ = ["app", "main"]


def main() -> None:
    """Run the command line."""
    app(prog_name="gridbloom")
