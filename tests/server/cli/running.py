"""The result of running the command."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any, NamedTuple


class Outcome(NamedTuple):
    status: int
    out: str
    err: str


Run = Callable[..., Outcome]


def state_counts(run: Run, *arguments: object) -> dict[str, Any]:
    """JSON output of ``map``."""
    status, out, err = run("map", *arguments, "--json")
    assert status == 0, err
    facts: dict[str, Any] = json.loads(out)
    return facts
