"""Hooks of MkDocs.

The page on the architecture gets a picture of the layers, drawn from the import contracts and the files. Docstrings
name objects with Sphinx roles (``:class:`ScanLog```), of which the site shows only the names. A page that loads
something from another host fails the build.
"""

from __future__ import annotations

import json
import re
import tomllib
from pathlib import Path
from typing import Any

ROOT = Path(__file__).parents[1]
PICTURE = "<!-- picture of the layers -->"  #: in the page, where the picture goes
_WIDTH, _ROW, _GAP = 300, 34, 24  # of a column and a layer, and between columns, pixels

_ROLE = re.compile(r":(?:attr|class|data|exc|func|meth|mod):(?=<code)")
_FOREIGN = re.compile(r"<(?:script|img|iframe|source|link)\b[^>]*\b(?:src|href)=[\"']?(?:https?:)?//[^>]*>")


def layers() -> dict[str, list[list[str]]]:
    """Return the layers of each part, the uppermost first, from the contracts that the checks run."""
    contracts = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"][
        "contracts"
    ]
    stated = {one["containers"][0]: one["layers"] for one in contracts if one["type"] == "layers"}
    parts = {name: [re.split(r"\s*[|:]\s*", layer) for layer in stated[name]] for name in ("mapper", "server")}
    rules = (ROOT / "static" / ".dependency-cruiser.cjs").read_text(encoding="utf-8")
    (front,) = re.findall(r"const LAYERS = (\[.*\]);", rules)
    return {**parts, "static/src": json.loads(front)}


def lines_of(part: str, name: str) -> int:
    """Return how many lines of code a package or module of a part has."""
    folder = ROOT / part / name
    files = folder.rglob("*.*") if folder.is_dir() else folder.parent.glob(f"{name}.py")
    return sum(
        path.read_text(encoding="utf-8").count("\n")
        for path in files
        if path.suffix in {".py", ".ts", ".tsx"} and ".test." not in path.name
    )


def picture_of_layers() -> str:
    """Return an SVG: a column for each part, a row for each layer, in it the packages with their lines of code.

    More than four packages are two rows.
    """
    parts = {
        part: [names[first : first + 4] for names in rows for first in range(0, len(names), 4)]
        for part, rows in layers().items()
    }
    height = _ROW * (max(len(rows) for rows in parts.values()) + 1)
    drawn = []
    for column, (part, rows) in enumerate(parts.items()):
        x = column * (_WIDTH + _GAP)
        drawn.append(f'<text x="{x}" y="20" font-weight="bold">{part}</text>')
        for number, names in enumerate(rows):
            y, left = _ROW * (number + 1), float(x)
            for name in names:
                width = _WIDTH * (len(name) + 3) / sum(len(other) + 3 for other in names)
                size = f"{name} {lines_of(part, name):,}" if len(names) < 3 else name
                look = 'rx="3" fill="none" stroke="currentColor" stroke-opacity="0.4"'
                title = f"<title>{name}: {lines_of(part, name):,} lines</title>"
                font = min(13.0, 1.6 * width / max(len(size), 1))
                box = f'x="{left:.0f}" y="{y}" width="{width - 4:.0f}" height="{_ROW - 6}"'
                drawn.append(f"<rect {box} {look}>{title}</rect>")
                drawn.append(f'<text x="{left + 6:.0f}" y="{y + 19}" font-size="{font:.1f}">{size}</text>')
                left += width
    total = len(parts) * (_WIDTH + _GAP) - _GAP
    head = f'viewBox="0 0 {total} {height}" width="100%" fill="currentColor" xmlns="http://www.w3.org/2000/svg"'
    return f'<svg {head} role="img" aria-label="Layers of the code">{"".join(drawn)}</svg>'


def on_page_markdown(markdown: str, **_: Any) -> str:  # noqa: ANN401 - MkDocs passes more than is used
    """Return a page's text with the picture of the layers in its place."""
    return markdown.replace(PICTURE, picture_of_layers()) if PICTURE in markdown else markdown


def on_page_content(html: str, **_: Any) -> str:  # noqa: ANN401 - MkDocs passes more than is used
    """Return a page's HTML without the roles."""
    return _ROLE.sub("", html)


def on_post_page(output: str, page: Any, **_: Any) -> str:  # noqa: ANN401 - MkDocs passes more than is used
    """Return a page as it is. Raises ``PluginError`` where it loads something from another host."""
    found = _FOREIGN.search(output)
    if found is not None:
        from mkdocs.exceptions import PluginError  # noqa: PLC0415 - only installed where the site is built

        raise PluginError(f"{page.file.src_uri} loads from another host: {found[0]}")
    return output
