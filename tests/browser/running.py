"""Start the service as a process of its own on a free loopback port, and Chromium with it."""

from __future__ import annotations

import os
import re
import socket
import subprocess
import sys
import time
import urllib.error
import urllib.request
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path

from playwright.sync_api import Browser, sync_playwright

from tests.browser.find_chromium import chromium
from tests.server.service import PATIENCE_S

START_SECONDS = 600.0  # a service that has not ended by itself is given time: it may have kernels to compile

# No calls home. Chromium finds out by itself that there is no graphics card, and paints pages as it does for anybody
# without one: "--use-angle=swiftshader" would put every page through a program that plays the card, which takes ten
# times as long. WebGL, as of a card, is there for the one test that draws with it.
# Chromium takes the last list of features only. Those of Playwright come first; without the others it draws the panels
# of its own window for each visitor, which takes a quarter of what it takes to open the lab.
_WITHOUT = [
    "AvoidUnnecessaryBeforeUnloadCheckSync", "DestroyProfileOnBrowserClose", "HttpsUpgrades",
    "HttpsFirstBalancedModeAutoEnable", "LensOverlay", "MediaRouter", "PaintHolding", "ThirdPartyStoragePartitioning",
    "AvoidCorsURLLoaderRestartOnRedirect", "OptimizationHints", "NetworkTimeServiceQuerying", "AimEnabled",
    "PreconnectToSearch",
    "PreloadTopChromeWebUI", "WebUIOmniboxPopup", "WebUIToolbar", "SpareRendererForSitePerProcess",
]  # fmt: skip
CHROMIUM_ARGUMENTS = [
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    f"--disable-features={','.join(_WITHOUT)}",
    "--enable-unsafe-swiftshader",
]


def free_port() -> int:
    """Return a loopback port that nothing listens on."""
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return int(s.getsockname()[1])


@contextmanager
def running_server(
    data_dir: Path, *arguments: str, environment: dict[str, str] | None = None, program: Sequence[str] = ()
) -> Iterator[str]:
    """Run `gridbloom serve` until the block ends; yield its address once it is ready. Its output goes to data_dir.

    ``program`` is another command that takes the same arguments.
    """
    with running_service(data_dir, *arguments, environment=environment, program=program) as (address, _):
        yield address


@contextmanager
def running_service(
    data_dir: Path, *arguments: str, environment: dict[str, str] | None = None, program: Sequence[str] = ()
) -> Iterator[tuple[str, subprocess.Popen[bytes]]]:
    """As :func:`running_server`; yield the address, and the process."""
    data_dir.mkdir(parents=True, exist_ok=True)
    log = data_dir / "server.log"
    gridbloom = program or [str(Path(sys.executable).with_name("gridbloom"))]
    # It chooses its port: one that is found free before may be taken by another program before it is bound.
    command = [*gridbloom, "serve", "--port", "0", "--data-dir", str(data_dir), *arguments]
    with log.open("ab") as output:
        told = output.tell()
        process = subprocess.Popen(
            command, stdout=output, stderr=subprocess.STDOUT, env=os.environ | (environment or {})
        )
    try:
        yield _ready_address(process, log, told), process
    finally:
        process.terminate()
        try:
            process.wait(PATIENCE_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
            raise


def _ready_address(process: subprocess.Popen[bytes], log: Path, told: int) -> str:
    """Wait until the service is ready; return its address, which it writes to ``log`` behind the first bytes."""
    deadline = time.monotonic() + START_SECONDS
    while time.monotonic() < deadline:
        if process.poll() is not None:
            raise RuntimeError(f"gridbloom serve ended with {process.returncode}:\n{log.read_text()[-4000:]}")
        found = re.search(rb"Gridbloom runs at (http://[\w.]+:\d+)/", log.read_bytes()[told:])
        if found is not None:
            address = found[1].decode()
            with (
                suppress(urllib.error.URLError, ConnectionError, TimeoutError),
                urllib.request.urlopen(f"{address}/readyz", timeout=60),
            ):
                return address
        time.sleep(0.1)
    raise RuntimeError(f"gridbloom serve was not ready after {START_SECONDS} s:\n{log.read_text()[-4000:]}")


@contextmanager
def running_chromium(*arguments: str) -> Iterator[Browser]:
    """Run headless Chromium until the block ends, with ``arguments`` beside :data:`CHROMIUM_ARGUMENTS` if need be."""
    program = chromium()  # before Playwright is started, which takes longer than to find that there is none
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=str(program),
            args=[*CHROMIUM_ARGUMENTS, *arguments],
            ignore_default_args=["--hide-scrollbars"],  # a person's pages have them
        )
        try:
            yield browser
        finally:
            browser.close()
