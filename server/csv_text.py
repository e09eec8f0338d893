"""Texts in CSV files that spreadsheets open."""

from __future__ import annotations

_FORMULA = ("=", "+", "-", "@")  #: with which a spreadsheet begins a formula, after any space


def as_text(cell: str) -> str:
    """Return a text that no spreadsheet takes for a formula: where it might, it begins with an apostrophe."""
    return f"'{cell}" if cell[:1] in ("\t", "\r") or cell.lstrip().startswith(_FORMULA) else cell
