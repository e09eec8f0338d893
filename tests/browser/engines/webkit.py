"""WebKit by WebDriver: WebKitGTK's MiniBrowser on a screen of Xvfb, through the driver program that comes with it."""

from __future__ import annotations

import base64
import http.client
import json
import os
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from tests.browser.engines.driver import Actions, DriverError, environment_of
from tests.browser.engines.processes import process_group
from tests.browser.engines.programs import WEBKIT
from tests.browser.looking import SECONDS, until
from tests.browser.running import free_port

# Without it the buttons of MiniBrowser make its window wider than a phone.
_NARROW = "* { padding: 0; margin: 0; min-width: 0; min-height: 0; font-size: 4px; border: none }\n"
# WebKit paints with the CPU. Its fences of GPU painting are deleted without a current context, without which libepoxy
# cannot resolve eglDestroySync at its first call: "No provider of eglDestroySync found", and the web process aborts.
_SOFTWARE = {"WEBKIT_SKIA_ENABLE_CPU_RENDERING": "1"}
_STILL = "[Settings]\ngtk-enable-animations=0\n"  # pages are told to move less
_ELEMENT = "element-6066-11e4-a52e-4f735466cecf"  #: the key of a reference to an element, in the standard
_RUN = """const done = arguments[1];
(async (given) => JSON.stringify((await (%s)(...JSON.parse(given))) ?? null))(arguments[0])
  .then((result) => done({ result }), (error) => done({ error: `${error}` }));"""


class WebKit:
    """A window of WebKit; see :class:`~tests.browser.engines.driver.Driver`."""

    name = "webkit"

    def __init__(self, port: int, session: str) -> None:
        self._port = port
        self._session = f"/session/{session}"
        self._tell("timeouts", script=int(1000 * SECONDS), pageLoad=int(1000 * SECONDS))

    def _tell(self, path: str, **parameters: Any) -> Any:
        return request(self._port, "POST", f"{self._session}/{path}", parameters)

    def goto(self, url: str) -> None:
        self._tell("url", url=url)

    def run(self, function: str, *arguments: Any) -> Any:
        answer = self._tell("execute/async", script=_RUN % function, args=[json.dumps(arguments)])
        if "error" in answer:
            raise DriverError(answer["error"])
        return json.loads(answer["result"])

    def perform(self, actions: Actions) -> None:
        self._tell("actions", actions=actions)

    def choose_files(self, selector: str, files: Sequence[Path]) -> None:
        element = self._tell("element", using="css selector", value=selector)[_ELEMENT]
        self._tell(f"element/{element}/value", text="\n".join(str(path) for path in files))

    def resize(self, width: int, height: int) -> None:
        bars = self.run("() => outerHeight - innerHeight")
        self._tell("window/rect", x=0, y=0, width=width, height=height + bars)
        until("the window's size", lambda: self.run("() => [innerWidth, innerHeight]") == [width, height])

    def screenshot(self) -> bytes:
        return base64.b64decode(request(self._port, "GET", f"{self._session}/screenshot"))

    def end(self) -> None:
        """Close the window and end MiniBrowser."""
        request(self._port, "DELETE", self._session)


def request(port: int, method: str, path: str, body: Any = None) -> Any:
    """Return the value of the driver's answer; raise :class:`DriverError` where it is an error."""
    connection = http.client.HTTPConnection("127.0.0.1", port, timeout=SECONDS)
    try:
        connection.request(method, path, None if body is None else json.dumps(body))
        answer = connection.getresponse()
        value = json.loads(answer.read())["value"]
    finally:
        connection.close()
    if answer.status != 200:
        raise DriverError(f"{path.rpartition('/')[2]}: {value['error']}: {value['message']}")
    return value


@contextmanager
def _screen(xvfb: Path, folder: Path) -> Iterator[str]:
    """Run an X server without a screen until the block ends; yield the name of its display, which it chooses."""
    reading, writing = os.pipe()
    command: list[str | Path] = [xvfb, "-displayfd", str(writing), "-screen", "0", "2000x1400x24", "-nolisten", "tcp"]
    with (
        os.fdopen(reading, "rb") as told,
        os.fdopen(writing, "wb") as telling,
        process_group(command, folder / "xvfb.log", dict(os.environ), [writing]),
    ):
        telling.close()  # so that reading ends when Xvfb does
        number = told.readline().decode().strip()
        assert number, (folder / "xvfb.log").read_text()[-4000:]
        yield f":{number}"


def _listens(port: int) -> bool:
    with suppress(OSError):
        return bool(request(port, "GET", "/status")["ready"])
    return False


@contextmanager
def running_webkit(folder: Path, *, dark: bool) -> Iterator[WebKit]:
    """Run WebKit with everything it keeps in ``folder`` until the block ends.

    Raises :class:`~tests.programs.MissingProgramError` where one of its programs is missing.
    """
    programs = WEBKIT.found()
    look = folder / "config" / "gtk-3.0"
    look.mkdir(parents=True)
    (look / "gtk.css").write_text(_NARROW)
    (look / "settings.ini").write_text(_STILL)
    options = {
        "binary": str(programs["MiniBrowser"]),
        "args": ["--automation", *(["--dark-mode"] if dark else [])],
    }
    with _screen(programs["Xvfb"], folder) as display:
        environment = environment_of(folder) | {"DISPLAY": display, "GDK_BACKEND": "x11"} | _SOFTWARE
        log, port = folder / "webkit.log", free_port()
        command: list[str | Path] = [programs["WebKitWebDriver"], f"--port={port}"]
        with process_group(command, log, environment) as process:

            def ready() -> bool:
                assert process.poll() is None, f"WebKitWebDriver ended:\n{log.read_text()[-4000:]}"
                return _listens(port)

            until("WebKitWebDriver to listen", ready)
            wanted = {"capabilities": {"alwaysMatch": {"webkitgtk:browserOptions": options}}}
            window = WebKit(port, request(port, "POST", "/session", wanted)["sessionId"])
            try:
                yield window
            finally:
                with suppress(DriverError, OSError):
                    window.end()
