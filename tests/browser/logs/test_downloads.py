"""The download buttons in Chromium: yaml and pgm are of one map, and no pair replaces another."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from playwright.sync_api import Page

from mapper.io.maps import load_map, pgm_bytes
from tests.browser.looking import frame, open_group, settled_digest, until


def take(page: Page, kind: str, folder: Path) -> Path:
    """Press a download button; save the file under the name that the browser gives it."""
    with page.expect_download() as found:
        page.get_by_role("link", name=kind, exact=True).click()
    path = folder / found.value.suggested_filename
    assert not path.exists()
    found.value.save_as(path)
    return path


def test_pairs_of_map_files(open_lab: Callable[..., Page], tmp_path: Path) -> None:
    lab = open_lab()
    open_group(lab, "Share")
    pairs = []
    for kinds in (("pgm", "yaml"), ("yaml", "pgm")):
        paths = {kinds[0]: take(lab, kinds[0], tmp_path)}
        index = frame(lab)["index"]
        lab.evaluate("() => gridbloom.connection.store.send({type: 'step', scans: 100})")
        until("the map to go on", lambda: frame(lab)["index"] >= index + 100)  # noqa: B023
        settled_digest(lab)
        pairs.append(paths | {kinds[1]: take(lab, kinds[1], tmp_path)})
    for paths in pairs:
        assert paths["pgm"].stem == paths["yaml"].stem
        assert paths["pgm"].stem.startswith("office_20")
        assert pgm_bytes(load_map(paths["yaml"]).grid) == paths["pgm"].read_bytes()
    assert pairs[0]["pgm"].read_bytes() != pairs[1]["pgm"].read_bytes()
    assert take(lab, "png", tmp_path).name == "office.png"
