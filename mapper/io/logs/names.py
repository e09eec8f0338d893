"""Sanitising of text from binary files for display in one line."""

from __future__ import annotations


def printable(text: str) -> str:
    """Return ``text`` with each non-printable character replaced: line ends, controls, overrides.

    A right-to-left override in a topic's name could reverse the sentence that contains it.
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else "\ufffd" for c in text)
