"""Texts in CSV files that spreadsheets open."""

from __future__ import annotations

_FORMULA = ("=", "+", "-", "@")  #: characters that start a formula in a spreadsheet, after any space


def as_text(cell: str) -> str:
    """Return a text that no spreadsheet interprets as a formula, prefixed by an apostrophe if necessary."""
    return f"'{cell}" if cell[:1] in ("\t", "\r") or cell.lstrip().startswith(_FORMULA) else cell
