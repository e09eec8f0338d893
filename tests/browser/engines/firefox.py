"""Firefox by WebDriver BiDi, which it speaks itself: no program between it and the tests."""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from itertools import count
from pathlib import Path
from typing import Any

from websockets.sync.client import connect
from websockets.sync.connection import Connection

from tests.browser.engines.driver import Actions, DriverError, environment_of
from tests.browser.engines.processes import process_group
from tests.browser.engines.programs import FIREFOX
from tests.browser.looking import SECONDS, until

_ADDRESS = re.compile(rb"WebDriver BiDi listening on (ws://\S+)")


def _preferences(*, dark: bool) -> str:
    """Return a profile's preferences: less motion, a colour scheme, and a proxy that refuses all other hosts.

    Without a screen Firefox has WebGL on few machines; it has none on any, so that tests see the same everywhere. A
    click gives no button the focus, as in browsers on macOS.
    """
    values: dict[str, str | int] = {
        "webgl.disabled": True,
        "accessibility.mouse_focuses_formcontrol": 0,
        "ui.prefersReducedMotion": 1,
        "layout.css.prefers-color-scheme.content-override": 0 if dark else 1,
        "network.proxy.type": 1,
        "network.proxy.http": "127.0.0.1",
        "network.proxy.http_port": 9,
        "network.proxy.ssl": "127.0.0.1",
        "network.proxy.ssl_port": 9,
    }
    return "".join(f"user_pref({json.dumps(name)}, {json.dumps(value)});\n" for name, value in values.items())


class Firefox:
    """A window of Firefox; see :class:`~tests.browser.engines.driver.Driver`."""

    name = "firefox"

    def __init__(self, socket: Connection) -> None:
        self._socket = socket
        self._ids = count(1)
        self._call("session.new", capabilities={})
        self._context = self._call("browsingContext.getTree")["contexts"][0]["context"]

    def _call(self, method: str, **parameters: Any) -> Any:
        number = next(self._ids)
        self._socket.send(json.dumps({"id": number, "method": method, "params": parameters}))
        while (answer := json.loads(self._socket.recv(SECONDS))).get("id") != number:
            pass
        if answer["type"] == "error":
            raise DriverError(f"{method}: {answer['error']}: {answer['message']}")
        return answer["result"]

    def goto(self, url: str) -> None:
        self._call("browsingContext.navigate", context=self._context, url=url, wait="complete")

    def run(self, function: str, *arguments: Any) -> Any:
        answer = self._call(
            "script.callFunction",
            functionDeclaration=f"async (given) => JSON.stringify((await ({function})(...JSON.parse(given))) ?? null)",
            arguments=[{"type": "string", "value": json.dumps(arguments)}],
            target={"context": self._context},
            awaitPromise=True,
        )
        if answer["type"] == "exception":
            raise DriverError(answer["exceptionDetails"]["text"])
        return json.loads(answer["result"]["value"])

    def perform(self, actions: Actions) -> None:
        self._call("input.performActions", context=self._context, actions=actions)

    def choose_files(self, selector: str, files: Sequence[Path]) -> None:
        locator = {"type": "css", "value": selector}
        nodes = self._call("browsingContext.locateNodes", context=self._context, locator=locator)["nodes"]
        element = {"sharedId": nodes[0]["sharedId"]}
        self._call("input.setFiles", context=self._context, element=element, files=[str(path) for path in files])

    def resize(self, width: int, height: int) -> None:
        self._call("browsingContext.setViewport", context=self._context, viewport={"width": width, "height": height})

    def screenshot(self) -> bytes:
        return base64.b64decode(self._call("browsingContext.captureScreenshot", context=self._context)["data"])


@contextmanager
def running_firefox(folder: Path, *, dark: bool) -> Iterator[Firefox]:
    """Run headless Firefox with a new profile in ``folder`` until the block ends.

    Raises :class:`~tests.programs.MissingProgramError` where there is no Firefox.
    """
    program, log, profile = FIREFOX.found()["Firefox"], folder / "firefox.log", folder / "profile"
    profile.mkdir()
    (profile / "user.js").write_text(_preferences(dark=dark))
    command: list[str | Path] = [
        program,
        "--headless",
        "--no-remote",
        "--remote-debugging-port",
        "0",
        "--profile",
        profile,
    ]
    with process_group(command, log, environment_of(folder)) as process:

        def address() -> str | None:
            assert process.poll() is None, f"Firefox ended with {process.returncode}:\n{log.read_text()[-4000:]}"
            found = _ADDRESS.search(log.read_bytes())
            return None if found is None else found[1].decode()

        listening = until("Firefox to listen", address)
        with connect(f"{listening}/session", max_size=None, proxy=None, ping_interval=None) as socket:
            yield Firefox(socket)
