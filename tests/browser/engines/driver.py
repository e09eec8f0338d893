"""What a browser engine is driven through: the same few actions for Firefox and WebKit."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Protocol

#: Sources of input and their actions, as both WebDriver and WebDriver BiDi write them.
Actions = list[dict[str, Any]]


class DriverError(RuntimeError):
    """The engine did not do what it was told: a script threw, or the page was gone."""


class Driver(Protocol):
    """One window of an engine, of a visitor of its own."""

    name: str

    def goto(self, url: str) -> None:
        """Open an address and wait until the page is loaded."""

    def run(self, function: str, *arguments: Any) -> Any:
        """Call a JavaScript function with arguments that JSON can hold; return its result, awaited if it is a promise.

        Raises :class:`DriverError` with the error that the function throws.
        """

    def perform(self, actions: Actions) -> None:
        """Move the mouse, press buttons and keys."""

    def choose_files(self, selector: str, files: Sequence[Path]) -> None:
        """Choose files in the input that a CSS selector names."""

    def resize(self, width: int, height: int) -> None:
        """Give the page this many CSS pixels."""

    def screenshot(self) -> bytes:
        """Return the visible part of the page as PNG."""


def environment_of(home: Path) -> dict[str, str]:
    """Return the environment of an engine that keeps everything in ``home`` and knows neither desktop nor proxy.

    It has a visitor's language: where there is none, WebKit names "C" as one, which formats of numbers refuse.
    """
    inherited = {
        name: value for name, value in os.environ.items() if not name.lower().endswith("_proxy") and name != "LC_ALL"
    }
    folders = {f"XDG_{kind}_HOME": str(home / kind.lower()) for kind in ("CONFIG", "CACHE", "DATA")}
    alone = {"DBUS_SESSION_BUS_ADDRESS": "disabled:", "GSETTINGS_BACKEND": "memory", "NO_AT_BRIDGE": "1"}
    return inherited | folders | alone | {"HOME": str(home), "LANG": "en_US.UTF-8"}
