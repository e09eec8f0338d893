"""Names of logs as people see them: cleaned for display, and never used as a path."""

from __future__ import annotations

import unicodedata

MAX_NAME = 120  #: characters of a name on the page


def display_name(name: str) -> str:
    """Return ``name`` as it may be shown: its last path component, on one line, at most :data:`MAX_NAME` characters.

    Control, format and surrogate characters go (a right-to-left override can make ``gnp.exe`` look like ``exe.png``);
    a name of which nothing is left becomes "log".
    """
    last = name.replace("\\", "/").rstrip("/").rsplit("/", 1)[-1]
    kept = "".join(" " if c.isspace() else c for c in last if c.isspace() or unicodedata.category(c)[0] != "C")
    clean = " ".join(kept.split()).strip(". ")
    if len(clean) > MAX_NAME:
        clean = clean[: MAX_NAME - 1].rstrip() + "…"
    return clean or "log"
