"""The answer of a route that returns a file, as the OpenAPI document describes it."""

from __future__ import annotations

from typing import Any

from fastapi.responses import Response


def file_answer(*media_types: str) -> dict[str, Any]:
    """Return the arguments of a route's decorator for an answer that is a file of one of these media types."""
    return {"response_class": Response, "responses": {200: {"content": {kind: {} for kind in media_types}}}}
