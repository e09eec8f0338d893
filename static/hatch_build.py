"""Build hook: makes static/dist before a wheel or an editable install is made, and puts it into the wheel.

Any failure stops the build: a wheel without pages would install well and serve nothing.
"""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

from hatchling.builders.hooks.plugin.interface import BuildHookInterface

# hatchling runs this file by its path, so the folder is not on Python's.
sys.path.insert(0, str(Path(__file__).parent))

from build_pages import DIST, build_pages


class PagesHook(BuildHookInterface[Any]):
    """Builds the pages, and puts them into a real wheel as server/pages."""

    PLUGIN_NAME = "custom"

    def initialize(self, version: str, build_data: dict[str, Any]) -> None:
        """Build; ``version`` is "editable" or "standard". An editable install serves static/dist where it lies."""
        build_pages()
        if version != "editable":
            build_data["force_include"][str(DIST)] = "server/pages"
