"""``/api/docs``: the HTTP interface on one page, from the OpenAPI document, without requests to other hosts."""

from __future__ import annotations

from html import escape
from typing import Any

from fastapi import APIRouter, Request
from fastapi.responses import HTMLResponse

router = APIRouter(prefix="/api", include_in_schema=False)


@router.get("/docs")
async def docs(request: Request) -> HTMLResponse:
    """Return the page with every path, method and parameter."""
    return HTMLResponse(_page(request.app.openapi()))


def _page(document: dict[str, Any]) -> str:
    info = document["info"]
    sections = "\n".join(
        _operation(method, path, operation)
        for path, methods in document["paths"].items()
        for method, operation in methods.items()
    )
    return (
        '<!doctype html><html lang="en"><head><meta charset="utf-8"><meta name="viewport" content="width=device-width">'
        f"<title>{escape(info['title'])}: HTTP interface</title></head><body><main>"
        f"<h1>{escape(info['title'])} {escape(info['version'])}: HTTP interface</h1>"
        '<p>For programs: <a href="/api/openapi.json">the OpenAPI document</a>. The stream of a session is a WebSocket '
        "at <code>/api/sessions/{session_id}/stream</code>, subprotocol <code>gridbloom.v3</code>. Every error is "
        "<code>{code, message, detail}</code>.</p>"
        f"{sections}</main></body></html>"
    )


def _operation(method: str, path: str, operation: dict[str, Any]) -> str:
    rows = "".join(
        f"<li><code>{escape(parameter['name'])}</code> ({escape(parameter['in'])}"
        f"{', required' if parameter.get('required') else ''})</li>"
        for parameter in operation.get("parameters", [])
    )
    answers = ", ".join(escape(code) for code in operation.get("responses", {}))
    return (
        f"<section><h2><code>{escape(method.upper())} {escape(path)}</code></h2>"
        f"<p>{escape(operation.get('description', operation.get('summary', '')))}</p>"
        f"{f'<ul>{rows}</ul>' if rows else ''}<p>Answers: {answers}</p></section>"
    )
