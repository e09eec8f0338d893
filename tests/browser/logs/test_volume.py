"""Maps in 3D on the logs page: a cloud, a zip of depth images and a recording, uploaded, drawn, asked and compared."""

from __future__ import annotations

import io
import re
import zipfile
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import trimesh
from PIL import Image
from playwright.sync_api import Page, WebSocket, expect
from playwright.sync_api import TimeoutError as PlaywrightTimeoutError

from mapper.io.clouds import read_cloud
from mapper.volume import OccupancyVolume, VolumeConfig
from tests.browser.looking import POLLING_MS, await_true, open_group, until
from tests.mapper.io.logs.recorded import SECOND, cloud, transform, written
from tests.mapper.volume.moving_lidar import record

T0 = 1000 * SECOND
DONE = """() => {
  const store = window.gridbloom?.connection.store;
  const [now, at] = [store?.part('volume').message.peek(), store?.frame.peek()];
  return Boolean(now && at && at.index === at.count && now.pending === 0 && now.nodes !== null && now.chunks > 0);
}"""
VOLUME = "() => gridbloom.connection.store.part('volume').message.peek()"


def opened(page: Page, server: str, *paths: Path) -> dict[str, Any]:
    """Upload files as one, open it in 3D, and wait until all of its scans are drawn."""
    page.goto(f"{server}/logs.html")
    page.set_input_files("input[type=file]", [str(path) for path in paths])
    await_true(page, "() => window.gridbloom?.connection.store.part('volume').message.peek()")
    page.evaluate(
        "() => { const { store } = gridbloom.connection;"
        " store.send({ type: 'seek', index: store.frame.peek()?.count ?? 1 }); }"
    )
    await_true(page, DONE)
    return dict(page.evaluate(VOLUME))


def coloured_share(page: Page) -> float:
    """Return the share of the 3D view's pixels that have the colour of a thing: the background is nearly white."""
    with Image.open(io.BytesIO(page.locator("iframe.volume-scene").screenshot())) as picture:
        pixels = np.asarray(picture.convert("RGB")).astype(np.int16)
    return float((np.ptp(pixels, axis=2) > 40).mean())


def test_real_depth_images_are_drawn_in_few_bytes_and_a_voxel_is_asked_about(
    page: Page, server: str, data_file: Callable[[str], Path], tmp_path: Path
) -> None:
    folder = data_file("depth/camera-intrinsics.txt").parent
    path = tmp_path / "room.zip"
    frames = sorted(folder.glob("*.depth.png"))[:2]
    with zipfile.ZipFile(path, "w") as archive:
        for file in [folder / "camera-intrinsics.txt", *frames]:
            archive.write(file, file.name)
        for file in frames:
            pose = file.name.replace(".depth.png", ".pose.txt")
            archive.write(folder / pose, pose)
    received = 0

    def count(socket: WebSocket) -> None:
        def add(data: str | bytes) -> None:
            nonlocal received
            received += len(data)

        if "/scenes/" in socket.url:
            socket.on("framereceived", add)

    page.on("websocket", count)
    volume = opened(page, server, path)
    assert volume["has_free"]
    assert volume["free"] > 5 * volume["occupied"] > 0
    # Playwright tells of what came only while it is asked for something.
    until("chunks are in the browser", lambda: page.title() and received > volume["occupied"] / 4)
    expect(page.locator(".volume-facts")).to_have_attribute("data-chunks", str(volume["chunks"]))
    assert volume["quads"] < volume["occupied"]

    box = page.locator("iframe.volume-scene").bounding_box()
    assert box is not None
    open_group(page, "Why")
    clicks = iter([(0.5, 0.5), (0.4, 0.5), (0.6, 0.45), (0.5, 0.4), (0.35, 0.45), (0.65, 0.5), (0.5, 0.6)] * 20)

    def asked() -> bool:
        right, down = next(clicks)
        page.evaluate("() => { window.voxelBefore = gridbloom.connection.store.part('voxel').message.peek(); }")
        page.mouse.click(box["x"] + right * box["width"], box["y"] + down * box["height"])
        # One click at a time: each has its answer, unless the scene was not yet there.
        with suppress(PlaywrightTimeoutError):
            page.wait_for_function(
                "() => gridbloom.connection.store.part('voxel').message.peek() !== voxelBefore",
                timeout=5000,
                polling=POLLING_MS,
            )
        return bool(page.evaluate("() => gridbloom.connection.store.part('voxel').message.peek()?.centre"))

    until("a voxel is asked about", asked)
    answer = page.locator("[data-voxel]")
    expect(answer).to_have_attribute("data-voxel", "occupied")
    assert int(answer.get_attribute("data-hits") or 0) >= 1
    expect(answer.get_by_text("ended in it").first).to_be_visible()
    # Each chunk is sent once, with what viser says of it, and old ones are not sent to who connects later.
    assert received < 4 * volume["occupied"] + 500 * volume["chunks"] + 100_000


def test_the_clouds_of_a_recording_fill_a_map_from_which_a_box_is_taken_away(
    page: Page, server: str, tmp_path: Path
) -> None:
    """Two recordings of one room: in the second the box is gone. A slice, a cut, and what vanished."""
    rng = np.random.default_rng(0)
    away = rng.normal(size=(3000, 3))
    away /= np.linalg.norm(away, axis=1)[:, None]
    walls = np.min(np.array([3.0, 2.5, 1.5]) / np.abs(away), axis=1)
    ahead = (away[:, 0] > 0) & (np.abs(away[:, 1:]) < 0.3 * away[:, :1]).all(axis=1)
    paths = []
    for name, ranges in (("box", np.where(ahead, 1.5, walls)), ("empty", walls)):
        said = [transform(T0, "base_link", "velodyne", 0.0, 0.0, z=0.0, topic="/tf_static")]
        for k in range(3):
            stamp = T0 + k * SECOND
            said += [transform(stamp, "odom", "base_link", 0.0, 0.0), cloud(stamp, away * ranges[:, None])]
        (tmp_path / name).mkdir()
        paths.append(written(tmp_path / name, said, "mcap"))
    ids = []
    for path in paths:
        answer = page.request.put(f"{server}/api/logs?name={path.parent.name}.mcap", data=path.read_bytes())
        ids.append(answer.json()["id"])
    page.goto(f"{server}/logs.html")
    card = page.locator(".log-card", has_text="box.mcap")
    card.get_by_role("button", name="Open in 3D").click()
    await_true(page, "() => window.gridbloom?.connection.store.part('volume').message.peek()")
    page.evaluate("() => gridbloom.connection.store.send({ type: 'seek', index: 3 })")
    await_true(page, DONE)
    whole = page.evaluate(VOLUME)

    page.get_by_label("Cut above, as a number").fill("0")
    page.get_by_label("Cut above, as a number").press("Enter")
    await_true(page, f"() => {{ const now = ({VOLUME})(); return now.pending === 0 && now.quads < {whole['quads']}; }}")
    open_group(page, "From above")
    page.get_by_role("button", name="Slice in the middle").click()
    until("the slice is shown", lambda: page.evaluate("() => gridbloom.cells().occupied") > 0)
    with page.expect_download() as download:
        page.locator(".volume-above").get_by_role("link", name="pgm").click()
    assert Path(download.value.path()).read_bytes().startswith(b"P5")
    open_group(page, "Download")
    with page.expect_download() as download:
        page.get_by_role("link", name="bt", exact=True).click()
    assert Path(download.value.path()).read_bytes().startswith(b"# Octomap OcTree binary file")

    page.goto(f"{server}/logs.html?log={ids[1]}&volume={ids[0]}")
    await_true(page, "() => window.gridbloom?.connection.store.part('volume').message.peek()")
    page.evaluate("() => gridbloom.connection.store.send({ type: 'seek', index: 3 })")
    await_true(page, f"() => ({VOLUME})()?.compared && ({DONE})()")
    open_group(page, "Compare")
    changes = page.locator(".volume-changes")
    assert int(changes.get_attribute("data-vanished") or 0) > 20
    assert int(changes.get_attribute("data-appeared") or 0) == 0


@pytest.mark.long
def test_a_bag_of_a_lidar_that_moves_becomes_the_map_of_its_points(
    page: Page, server: str, data_file: Callable[[str], Path], tmp_path: Path
) -> None:
    """Messages of four layouts, whose points state their times, as a ROS 1 bag, opened in 3D."""
    points = read_cloud(data_file("pointclouds/room_scan1.pcd")).points
    run = record(tmp_path, points[np.isfinite(points).all(axis=1)][::10], "bag")
    assert page.request.put(f"{server}/api/logs?name=run.bag", data=run.path.read_bytes()).ok
    page.goto(f"{server}/logs.html")
    page.locator(".log-card", has_text="run.bag").get_by_role("button", name="Open in 3D").click()
    await_true(page, "() => window.gridbloom?.connection.store.part('volume').message.peek()")
    page.evaluate("() => gridbloom.connection.store.send({ type: 'seek', index: 4 })")
    await_true(page, DONE)
    volume = page.evaluate(VOLUME)
    resolution = page.evaluate("() => gridbloom.connection.store.hello.peek().parameters.values.resolution")
    expected = OccupancyVolume(VolumeConfig(resolution=resolution))
    for true, origin in zip(run.truth, run.origins, strict=True):
        expected.insert_scan(true, origin)
    hits, free = expected.voxels(0.0)[0], expected.n_known
    assert volume["has_free"]
    assert volume["occupied"] == pytest.approx(len(hits), rel=0.05)
    assert volume["occupied"] + volume["free"] == pytest.approx(free, rel=0.05)


@pytest.mark.parametrize("name", ["pointclouds/room_scan1.pcd"])
def test_a_real_cloud_is_drawn_as_voxels_and_as_points(
    name: str, page: Page, server: str, data_file: Callable[[str], Path]
) -> None:
    path = data_file(name)
    volume = opened(page, server, path)
    cloud = read_cloud(path)
    assert (volume["points"], volume["free"]) == (int(cloud.finite.sum()), 0)
    resolution = page.evaluate("() => gridbloom.connection.store.hello.peek().parameters.values.resolution")
    expected = OccupancyVolume(VolumeConfig(resolution=resolution))
    expected.insert_scan(cloud.points[cloud.finite], None)
    assert volume["occupied"] == expected.n_known
    until("the voxels are in the picture", lambda: coloured_share(page) > 0.1)
    page.get_by_role("radio", name="points", exact=True).check(force=True)
    await_true(page, f"() => ({VOLUME})().chunks === 0")
    expect(page.locator(".volume-facts")).to_contain_text("112,586 points")

    # The clip box, by keyboard and by number: what is in it is saved, and a click says what is known of a point.
    middle = 0.5 * (volume["low"][0] + volume["high"][0])
    handle = page.get_by_label("Clip x to", exact=True)
    handle.focus()
    handle.press("PageDown")
    await_true(page, f"() => ({VOLUME})().look.values.cut_x_high < {volume['high'][0] + 0.5}")
    expect(page.get_by_label("Clip x from, as a number")).to_have_value(re.compile(r"−\d+\.\d\d"))  # a true minus sign
    page.get_by_label("Clip x to, as a number").fill(f"{middle:.2f}")
    # What is typed stays while the page is drawn again.
    page.evaluate("() => gridbloom.connection.store.send({ type: 'volume_look', values: { point_size: 2 } })")
    await_true(page, f"() => ({VOLUME})().look.values.point_size === 2")
    expect(page.get_by_role("slider", name="Point size")).to_have_attribute("aria-valuetext", "2.00")
    expect(page.get_by_label("Clip x to, as a number")).to_have_value(f"{middle:.2f}")
    page.get_by_label("Clip x to, as a number").press("Enter")
    await_true(page, f"() => ({VOLUME})().look.values.cut_x_high === {round(middle, 2)}")
    open_group(page, "Download")
    with page.expect_download() as download:
        page.get_by_role("link", name="points in the clip box").click()
    shown = cloud.points[cloud.finite]
    shown = shown[(shown[:, 0] <= round(middle, 2)) & (shown[:, 2] <= volume["look"]["values"]["cut_high"])]
    with Path(download.value.path()).open("rb") as ply:
        saved = trimesh.load(ply, file_type="ply")
    assert isinstance(saved, trimesh.PointCloud)
    np.testing.assert_allclose(np.asarray(saved.vertices), shown, atol=1e-5)
    x, y, z = shown[len(shown) // 2].tolist()
    page.evaluate(f"() => gridbloom.connection.store.send({{ type: 'voxel', x: {x}, y: {y}, z: {z} }})")
    expect(page.locator("[data-points]")).to_contain_text(f"{x:.2f}, {y:.2f}, {z:.2f}".replace("-", "−"))
    open_group(page, "View")
    page.get_by_role("button", name="Draw the whole map").click()
    await_true(page, f"() => ({VOLUME})().look.values.cut_x_high > {volume['high'][0]}")


@pytest.mark.long
def test_the_surface_of_real_depth_images_follows_its_parameters_and_is_taken_away(
    page: Page, server: str, data_file: Callable[[str], Path], tmp_path: Path
) -> None:
    folder = data_file("depth/camera-intrinsics.txt").parent
    path = tmp_path / "desk.zip"
    with zipfile.ZipFile(path, "w") as archive:
        for file in [folder / "camera-intrinsics.txt", *sorted(folder.glob("frame-00004*"))]:
            archive.write(file, file.name)
    received: list[int] = []
    page.on(
        "websocket",
        lambda socket: (
            socket.on("framereceived", lambda data: received.append(len(data))) if "/scenes/" in socket.url else None
        ),
    )
    opened(page, server, path)
    before = sum(received)
    open_group(page, "Surface")
    page.get_by_role("button", name="Show the surface").click()
    surface = "() => gridbloom.connection.store.part('surface').message.peek()"
    await_true(
        page, f"() => {{ const now = ({surface})(); return now.index === 1 && now.triangles > 0 && !now.pending; }}"
    )
    first = page.evaluate(surface)
    expect(page.locator(".volume-facts")).to_contain_text(f"{first['triangles']:,} triangles of 1 scan")

    def arrived() -> bool:
        page.evaluate("() => true")  # what the page received is told here only while Playwright is called
        return sum(received) - before > 2 * int(first["triangles"])

    until("the triangles are in the browser", arrived)

    # The curve is grabbed with the keyboard: other triangles, made of the same image.
    handle = page.get_by_role("slider", name="Truncation").first
    handle.focus()
    handle.press("ArrowRight")
    until("the truncation has changed", lambda: page.evaluate(surface)["truncation"] != first["truncation"])
    await_true(
        page, f"() => {{ const now = ({surface})(); return now.index === 1 && now.triangles > 0 && !now.pending; }}"
    )
    second = page.evaluate(surface)
    assert second["triangles"] != first["triangles"]

    open_group(page, "Download")
    with page.expect_download() as download:
        page.get_by_role("link", name="ply", exact=True).click()
    with Path(download.value.path()).open("rb") as ply:
        mesh = trimesh.load_mesh(ply, file_type="ply", process=False)
    assert len(mesh.faces) == second["triangles"]
    np.testing.assert_allclose(np.linalg.norm(mesh.vertex_normals, axis=1), 1.0, atol=1e-3)

    # The camera's y points down: with −y up the map is another one, as the address says.
    open_group(page, "View")
    page.get_by_label("Axis of the file that points up").select_option("-y")
    page.wait_for_url("**up=-y**")
    await_true(page, f"() => {{ const now = ({VOLUME})(); return now && now.low[2] > -2 && now.low[2] < 0; }}")
