"""The parts of sessions. :data:`PARTS` is the only list that names them.

A part is a folder here. The service uses these modules of it, each of which is optional:

``messages``  ``COMMANDS`` and ``MESSAGES``, the Structs that it adds to the stream (:mod:`server.parts.wire`)
``part``      ``part_of``, which returns its :class:`server.sessions.part.Part` for what a source offers, or None;
              without it, sources create the part themselves
``routes``    ``router``, its routes
"""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from importlib.util import find_spec
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from server.sessions.part import Offers, Part

#: each after the parts whose results it uses
PARTS = (
    "why",
    "comparison",
    "slam",
    "localization",
    "volume",
    "terrain",
    "costmap",
    "path",
    "editing",
    "doctor",
    "notes",
)


def stated(module: str, name: str) -> Iterator[Any]:
    """Import the parts' modules of this name, and yield their attribute ``name``, in the order of :data:`PARTS`."""
    for part in PARTS:
        if find_spec(path := f"{__name__}.{part}.{module}") is not None:
            names = vars(import_module(path))
            if name in names:
                yield names[name]


def parts_of(offers: Offers) -> list[Part]:
    """Return the parts whose requirements are met, in the order in which they follow the source."""
    made = (part_of(offers) for part_of in stated("part", "part_of"))
    return [part for part in made if part is not None]
