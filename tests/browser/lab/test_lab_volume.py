"""The lab's 3D map in Chromium: an octree fills while the robot drives, with the low table that the 2D map lacks."""

from __future__ import annotations

import re
from collections.abc import Callable

import pytest
from playwright.sync_api import Page, expect

from tests.browser.lecturing import never_idle
from tests.browser.looking import await_true, carried_out, drag_along, open_group, until, without_canvas_in_3d
from tests.marks import also_long

_STORE = "gridbloom.connection.store"
_MESSAGE = f"() => {_STORE}.part('map3d').message.peek()"
LOW_TABLE = [4.0, 3.0]  # the middle of its board, below the plane of the flat lidar

#: The byte of the layer of what only the 3D map has, at a place: 0 unknown, 1 free, 2 in both maps, 3 only in 3D.
_BYTE = f"""([x, y]) => {{
  const map = {_STORE}.layers.grid('only_in_3d').map.peek();
  if (!map) return 0;
  const {{ resolution, origin }} = map.geometry;
  return map.cells.at(Math.floor((y - origin[1]) / resolution), Math.floor((x - origin[0]) / resolution));
}}"""

#: Whether the first entry of P, the number of points, is that of the points of the newest message.
_AS_MANY_POINTS = f"""() => {{
  const n = {_STORE}.part('terrain').message.peek()?.patch?.points.length / 3;
  return document.querySelector(".terrain-asked .patch-matrix td")?.textContent === `${{n}}`;
}}"""


@pytest.mark.parametrize("is_drawn", also_long(False, True))
def test_the_low_table_is_in_the_3d_map_and_not_in_the_2d_one(
    page: Page, open_lab: Callable[..., Page], is_drawn: bool
) -> None:
    if not is_drawn:
        without_canvas_in_3d(page)  # the surface below is drawn
    open_lab("levels")
    panel = open_group(page, "3D map")
    usual = page.viewport_size or {"width": 1280, "height": 720}
    page.set_viewport_size({"width": 1024, "height": 700})
    expect(panel.get_by_title("3D view")).to_be_in_viewport(ratio=0.3)
    page.set_viewport_size(usual)
    page.evaluate(f"() => {_STORE}.send({{ type: 'play' }})")
    for x, y in ((2.6, 3.0), (4.0, 1.6), (5.6, 3.0), (4.0, 4.6)):
        before = page.evaluate(_MESSAGE)["scans"]
        page.evaluate(f"([x, y]) => {_STORE}.teleport([x, y])", [x, y])
        await_true(page, f"(n) => ({_MESSAGE})().scans >= n + 2", arg=before)
    until("the low table to be missing in 2D", lambda: page.evaluate(_BYTE, LOW_TABLE) == 3)
    assert page.evaluate("(xy) => gridbloom.readState(xy).state", LOW_TABLE) == "free"
    expect(panel.get_by_role("status")).to_contain_text("the 2D map lacks")
    if is_drawn:  # its layers are those of the scene, and there is a canvas
        expect(panel.get_by_role("button", name="3D map", exact=True)).to_be_visible()
        expect(panel.frame_locator("iframe").locator("canvas").first).to_be_visible()
    # Its points make a terrain: patches are classified, and a click on the map asks about one.
    terrain = open_group(page, "Terrain")
    await_true(page, f"() => {_STORE}.part('terrain').message.peek()?.safe > 100")
    await_true(page, f"() => {_STORE}.layers.grid('terrain_costs').map.peek() !== null")
    expect(page.locator(".readout-legend ul")).to_be_hidden()  # it names the map's colours, which do not show
    page.evaluate(f"() => {{ {_STORE}.pinned.value = [3.0, 4.4]; }}")
    asked = terrain.get_by_label("The patch that was clicked")
    expect(asked).to_contain_text("Patch of 0.25 m at (3.0, 4.4)")
    await_true(page, f"() => {_STORE}.part('terrain').message.peek()?.patch?.points.length > 9")
    page.evaluate(f"() => {_STORE}.send({{ type: 'pause' }})")  # else each assessment has other points
    expect(asked.get_by_role("cell").first).to_be_visible()
    await_true(page, _AS_MANY_POINTS)
    panel = open_group(page, "3D map")
    # Coarser voxels need less memory, live.
    fine = page.evaluate(_MESSAGE)
    voxel = panel.get_by_role("slider", name="Voxel")
    voxel.focus()
    for _ in range(4):
        page.keyboard.press("ArrowRight")
    await_true(page, f"() => {{ const m = ({_MESSAGE})(); return m.values.voxel > 0.25 && m.scans === m.taken; }}")
    until("the octree to be counted", lambda: 0 < page.evaluate(_MESSAGE)["nodes"] < fine["nodes"] / 4)
    expect(panel.get_by_label("Memory of the 3D map")).to_contain_text("Dense grid")
    # The costmap stands on it: the table is lethal there.
    panel.get_by_role("switch", name="Costmap over the 3D map").click()
    await_true(page, f"() => {_STORE}.part('costmap').message.peek()?.values.map === 'map_3d'")
    panel.get_by_role("button", name="End the 3D map").click()
    await_true(page, f"() => !({_MESSAGE})().is_on")
    expect(panel.get_by_role("button", name="Begin a 3D map")).to_be_visible()


def test_the_same_scans_are_a_surface_whose_curve_is_grabbed(open_lab: Callable[..., Page]) -> None:
    page = open_lab("levels")
    received: list[int] = []
    page.on(
        "websocket",
        lambda socket: (
            socket.on("framereceived", lambda data: received.append(len(data))) if "/scenes/" in socket.url else None
        ),
    )

    def arrived() -> int:
        page.evaluate("() => true")  # what the page received is told here only while Playwright is called
        return sum(received)

    panel = open_group(page, "3D map")
    page.evaluate(f"() => {_STORE}.send({{ type: 'play' }})")
    await_true(page, f"() => ({_MESSAGE})().scans >= 3")
    expect(panel.get_by_role("button", name="3D map", exact=True)).to_be_visible()
    page.evaluate(f"() => {_STORE}.send({{ type: 'pause' }})")
    carried_out(page)  # no scan comes after it
    panel.get_by_role("radio", name="TSDF").check()
    surface = f"() => {_STORE}.part('surface').message.peek()"
    settled = f"""() => {{
      const now = ({surface})();
      return now?.index === ({_MESSAGE})().taken && now.triangles > 0 && !now.pending;
    }}"""
    await_true(page, settled)
    # The layers of the 3D view follow what it shows.
    layers = panel.get_by_role("group", name="Layers")
    expect(layers.get_by_role("button", name="Surface", exact=True)).to_be_visible()
    expect(layers.get_by_role("button", name="3D map", exact=True)).to_have_count(0)
    first = page.evaluate(surface)
    figure = panel.get_by_role("figure", name="One beam as occupancy and as signed distance")
    curve = figure.locator(".tsdf-line")
    drawn = curve.get_attribute("d")
    before = arrived()
    # The truncation is dragged to the right, towards the wall: a narrower band, fewer voxels, another mesh.
    truncation = figure.get_by_role("slider", name="Truncation")
    truncation.scroll_into_view_if_needed()
    box = truncation.locator(".handle-mark").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    drag_along(page, (x, y), (x + 20, y), steps=4)
    until("the curve to change", lambda: curve.get_attribute("d") != drawn)
    until("the truncation to change", lambda: page.evaluate(surface)["truncation"] < first["truncation"])
    await_true(page, settled)
    second = page.evaluate(surface)
    assert second["triangles"] != first["triangles"]
    assert second["blocks"] < first["blocks"]
    until("its triangles to be in the browser", lambda: arrived() - before > 2 * second["triangles"])
    # So is the maximum weight, here with the keyboard.
    weight = figure.get_by_role("slider", name="Maximum weight")
    weight.focus()
    weight.press("Home")
    until("the maximum weight to change", lambda: page.evaluate(surface)["values"]["max_weight"] == 1)
    await_true(page, settled)
    # And taken back.
    page.keyboard.press("Control+z")
    until("the maximum weight to be as before", lambda: page.evaluate(surface)["values"]["max_weight"] == 64)
    panel.get_by_role("radio", name="Occupancy").check()
    expect(figure).to_be_hidden()
    expect(layers.get_by_role("button", name="3D map", exact=True)).to_be_visible()
    expect(layers.get_by_role("button", name="Surface", exact=True)).to_have_count(0)


def test_the_lecture_leads_to_both_maps_in_the_lab(page: Page, server: str) -> None:
    never_idle(page)
    without_canvas_in_3d(page)
    page.goto(f"{server}/lecture.html#tsdf")
    link = page.get_by_role("link", name="Open in the lab, in 3D")
    expect(link).to_have_attribute("href", re.compile("group=map3d"))
    link.click()
    panel = page.get_by_role("tabpanel", name="3D map")
    expect(panel.get_by_role("radio", name="TSDF")).to_be_checked()
    expect(panel.get_by_role("figure", name="One beam as occupancy and as signed distance")).to_be_visible()
