"""A service whose pages tell what goes wrong on them, and a visitor's page in Firefox or WebKit."""

from __future__ import annotations

import re
import shutil
import tempfile
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager
from pathlib import Path

import pytest

from server.http import page_files
from tests.browser.engines.driver import Driver
from tests.browser.engines.firefox import running_firefox
from tests.browser.engines.tab import DESKTOP, Tab
from tests.browser.engines.webkit import running_webkit
from tests.server.service import Service, running, settings_for

WATCH = Path(__file__).with_name("watch.js")
ENGINES: dict[str, Callable[..., AbstractContextManager[Driver]]] = {
    "firefox": running_firefox,
    "webkit": running_webkit,
}


def watched_pages(folder: Path) -> Path:
    """Return a copy of the built pages, and of the script of the 3D view, that begin with ``watch.js``."""
    built = page_files.find_pages()
    assert built is not None, "the pages are not built"
    pages = Path(shutil.copytree(built, folder))
    shutil.copy(WATCH, pages / "assets" / "watch.js")
    for page in pages.glob("*.html"):
        text, replaced = re.subn("<head>", '<head><script src="/assets/watch.js"></script>', page.read_text())
        assert replaced == 1
        page.write_text(text)
    scene = pages / "scene.js"
    scene.write_text(WATCH.read_text() + scene.read_text())
    return pages


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    """A service whose pages are watched."""
    folder = tmp_path_factory.mktemp("engines")
    with pytest.MonkeyPatch.context() as patch, running(settings_for(folder / "data")) as service:
        patch.setattr(page_files, "PLACES", (watched_pages(folder / "pages"),))
        yield service


@pytest.fixture(params=sorted(ENGINES))
def tab(request: pytest.FixtureRequest, service: Service) -> Iterator[Tab]:
    """A new visitor's page in an engine, in light colours in one and dark ones in the other.

    The test fails at its end if anything went wrong on a page: an error, a request that failed.
    """
    name, address = request.param, f"http://127.0.0.1:{service.port}"
    # What an engine writes while it ends is no fault, and its sockets need a short path.
    with (
        tempfile.TemporaryDirectory(prefix=f"{name}-", ignore_cleanup_errors=True) as folder,
        ENGINES[name](Path(folder), dark=name == "webkit") as driver,
    ):
        tab = Tab(driver, address)
        driver.resize(*DESKTOP)
        yield tab
        assert tab.problems() == []
        tab.end_sessions()
