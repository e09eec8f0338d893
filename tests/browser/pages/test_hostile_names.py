"""Names of topics, frames, logs, maps and tags that harm, and such notes: they are text, in their boxes."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

from playwright.sync_api import Page, expect

from mapper.grid import GridGeometry, OccupancyGrid
from mapper.io.maps import save_map
from server.library.annotations.tags import MAX_TAG_LENGTH
from tests.browser.looking import await_map, open_group
from tests.mapper.io.contents.recorded_robot import T0, robot
from tests.mapper.io.logs import recorded
from tests.server.http.test_localization import tarred
from tests.server.service import until

MARK = "zq"  #: in each name
NAMES = (
    '<img src=zq onerror="window.ran = 1">',
    '"><script>window.ran = 1</script>zq',
    "zq\u202egnp.tob",  # what follows is written from right to left
    "zq" + "w" * 298,
)

# What is wrong with the page: a name that became an element, or ran; text of a name outside the box that it is in.
# Inline boxes have no width of their own; a box that scrolls, or cuts off, is the last that is looked at.
_WRONG = """(mark) => {
  const wrong = window.ran ? ["a name has run"] : [];
  for (const one of document.querySelectorAll("img, script"))
    if (one.outerHTML.includes(mark) && !one.getAttribute("alt")?.includes(mark)) wrong.push(one.outerHTML);
  const walker = document.createTreeWalker(document.body, NodeFilter.SHOW_TEXT);
  for (let node = walker.nextNode(); node; node = walker.nextNode()) {
    if (!node.data.includes(mark) || !node.parentElement.checkVisibility({ visibilityProperty: true })) continue;
    const range = document.createRange();
    range.selectNodeContents(node);
    const right = Math.max(...[...range.getClientRects()].map((rect) => rect.right));
    for (let one = node.parentElement; one; one = one.parentElement) {
      const style = getComputedStyle(one);
      if (style.overflowX !== "visible") break;
      if (style.display === "inline" || style.display === "contents") continue;
      if (right > one.getBoundingClientRect().right + 1.5)
        wrong.push(`${node.data.slice(0, 40)} leaves ${one.outerHTML.slice(0, 120)}`);
    }
  }
  if (document.scrollingElement.scrollWidth > innerWidth) wrong.push("the page is wider than the window");
  return wrong;
}"""


def renamed(value: Any, names: dict[str, str]) -> Any:
    """Fields of a message with other names of frames."""
    if isinstance(value, dict):
        return {key: renamed(one, names) for key, one in value.items()}
    if isinstance(value, list):
        return [renamed(one, names) for one in value]
    return names.get(value, value) if isinstance(value, str) else value


def hostile_recording() -> bytes:
    """A recording whose topics and frames have the names."""
    topics = dict(zip(("/imu", "/battery", "/cmd_vel", "/odom"), NAMES, strict=True))
    said = [
        replace(one, topic=topics.get(one.topic, one.topic), fields=renamed(one.fields, {"laser": NAMES[0]}))
        for one in robot(2)
    ]
    frames = [recorded.transform(T0, "base_link", name, 0.1, topic="/tf_static") for name in NAMES[1:]]
    return recorded.mcap_bytes([*frames, *said])


def check(page: Page, where: str) -> None:
    assert page.evaluate(_WRONG, MARK) == [], where


def test_names_and_notes_are_text_and_stay_in_their_boxes(page: Page, server: str, tmp_path: Path) -> None:
    def put(name: str, data: bytes) -> str:
        answer = page.request.put(f"{server}/api/logs", params={"name": name}, data=data)
        assert answer.ok, answer.text()
        return str(answer.json()["id"])

    log = put(NAMES[0], hostile_recording())
    grid = OccupancyGrid(GridGeometry(0.1, 64, 64))
    grid.observed[10:40, 10:40] = True
    files = tarred(*save_map(grid, tmp_path / "map"))
    ids = [log, *(put(name, files + bytes(512 * n)) for n, name in enumerate(NAMES[1:]))]

    def are_read() -> bool:
        return all(page.request.get(f"{server}/api/logs/{one}").json()["state"] == "ready" for one in ids)

    until(are_read)
    tags = [name[:MAX_TAG_LENGTH] for name in NAMES if name.isprintable()]
    expect(page.request.put(f"{server}/api/logs/{log}/tags", data={"tags": tags})).to_be_ok()
    page.goto(f"{server}/logs.html")
    expect(page.locator(".log-card", has_text=MARK)).to_have_count(len(NAMES))
    check(page, "the list of logs")

    page.locator(".log-card", has_text=NAMES[0]).get_by_role("button", name="Open map").click()
    await_map(page)
    notes = open_group(page, "Notes")
    for number, name in enumerate(NAMES, start=1):
        notes.get_by_label("New note").fill(name)
        notes.get_by_role("button", name="Add note").click()
        expect(notes.locator(".note")).to_have_count(number)  # the field is emptied then
    check(page, "Notes")
    for title in ("Topics", "Frames", "Trajectories"):
        expect(open_group(page, title)).to_contain_text(MARK)
        check(page, title)
