"""Sanitising of text from binary files for display in one line."""

from __future__ import annotations


def printable(text: str) -> str:
    """Return ``text`` with each non-printable character replaced: line ends, controls, overrides."""
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else "\ufffd" for c in text)
