"""Hooks of MkDocs.

Docstrings name objects with Sphinx roles (``:class:`ScanLog```), of which the site shows only the names. A page that
loads something from another host fails the build.
"""

from __future__ import annotations

import re
from typing import Any

_ROLE = re.compile(r":(?:attr|class|data|exc|func|meth|mod):(?=<code)")
_FOREIGN = re.compile(r"<(?:script|img|iframe|source|link)\b[^>]*\b(?:src|href)=[\"']?(?:https?:)?//[^>]*>")


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
