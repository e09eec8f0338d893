"""Words out of a binary file as they may be shown: in one line, and as what they are."""

from __future__ import annotations


def printable(text: str) -> str:
    """Return ``text`` with a replacement character for each that is not printable: line ends, controls, overrides.

    A right-to-left override in a topic's name could turn the sentence around that the name stands in.
    """
    if text.isprintable():
        return text
    return "".join(c if c.isprintable() else "\ufffd" for c in text)
