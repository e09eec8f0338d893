"""Files as answers and request bodies, as described in the OpenAPI document."""

from __future__ import annotations

from typing import Any

from fastapi.responses import Response

#: the argument ``openapi_extra`` of a route's decorator if the body is a file, which the route reads as it arrives
FILE_BODY = {
    "requestBody": {
        "required": True,
        "content": {"application/octet-stream": {"schema": {"type": "string", "format": "binary"}}},
    }
}


def file_answer(*media_types: str) -> dict[str, Any]:
    """Return the arguments of a route's decorator for an answer that is a file of one of these media types."""
    return {"response_class": Response, "responses": {200: {"content": {kind: {} for kind in media_types}}}}
