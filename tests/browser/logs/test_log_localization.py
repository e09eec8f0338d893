"""The page of a log localizes its robot in a map: the map is chosen, the start clicked, the course shown."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from playwright.sync_api import BrowserContext, Page, expect

from tests.browser.looking import await_end, await_true, open_group, until
from tests.marks import also_long

_STORE = "gridbloom.connection.store"


def amcl_yaml(tmp_path: Path, *lines: str) -> Path:
    """Write parameters of an AMCL, one line for each."""
    yaml = tmp_path / "amcl.yaml"
    yaml.write_text("".join(f"{line}\n" for line in ("amcl:", "  ros__parameters:", *(f"    {one}" for one in lines))))
    return yaml


#: In `make test` a filter with few particles, in `make test-long` with as many as by default.
@pytest.mark.parametrize(
    "parameters",
    [("max_particles: 500", "# gridbloom: global_particles: 2000"), *also_long(())],
    ids=["few particles", "defaults"],
)
def test_the_sample_is_localized_in_its_own_map(
    page: Page, server: str, tmp_path: Path, parameters: tuple[str, ...]
) -> None:
    page.goto(f"{server}/logs.html")
    page.get_by_role("button", name="Open map").first.click()
    await_true(page, "() => window.gridbloom && gridbloom.cells().free > 50")
    panel = open_group(page, "Localize")
    # The map is proposed along the poses that the page shows.
    for name in ("odometry", "true"):
        page.evaluate(f"name => {_STORE}.send({{ type: 'trajectory', name }})", name)
        expect(panel.get_by_label("Mapped along")).to_have_value(name)
    panel.get_by_role("button", name="Use this map").click()
    find = panel.get_by_role("button", name="Find the robot")
    expect(find).to_be_enabled()
    await_true(page, f"() => {_STORE}.layers.grid('given_map').map.peek() !== null")
    panel.get_by_text("Parameters of the filter").click()
    yaml = amcl_yaml(tmp_path, "laser_model_type: likelihood_field_prob", *parameters, "scan_topic: front")
    panel.get_by_label("Yaml of an AMCL").set_input_files(yaml)
    expect(panel.get_by_text("Without effect here, and kept where you save: scan_topic.")).to_be_visible()
    # A click says where the robot starts, a second one where it looks.
    panel.get_by_text("At a pose").click()
    expect(find).to_be_disabled()
    start = page.evaluate(f"() => {_STORE}.trajectory.peek().poses[0]")
    picture = page.get_by_role("application").first
    box = picture.bounding_box()
    assert box is not None
    for east in (0.0, 1.0):
        x, y = page.evaluate(
            f"""([x, y]) => {{ const view = {_STORE}.view.peek();
                return [(x - view.x) / view.scale, (view.y - y) / view.scale]; }}""",
            [start[0] + east, start[1]],
        )
        page.mouse.click(box["x"] + box["width"] / 2 + x, box["y"] + box["height"] / 2 + y)
    expect(panel.get_by_label("heading (°)")).to_have_value("0.00")
    assert abs(float(panel.get_by_label("x (m)").input_value()) - start[0]) < 0.1
    find.click()
    await_true(page, f"() => {_STORE}.trajectory.peek()?.name === 'localized'")
    await_end(panel.get_by_role("progressbar"))
    expect(panel.get_by_text("Found: the poses in the map")).to_be_in_viewport(ratio=1)
    panel.get_by_role("button", name=re.compile("^Go to the start, ")).click()
    await_true(page, f"() => {_STORE}.part('localization').message.peek()?.n_updates === 1")

    def particles() -> list[float]:
        """The particles' x; a layer comes after the message of the same moment."""
        return list(page.evaluate(f"() => [...{_STORE}.layers.content('particles').peek()?.columns[0] ?? []]"))

    until("the first particles", lambda: (xs := particles()) and abs(sum(xs) / len(xs) - start[0]) < 0.5)
    assert len(particles()) > 99
    expect(panel.get_by_text("Entropy of the particles")).to_be_visible()


def test_what_cannot_be_used_is_said(visitor: BrowserContext, server: str, tmp_path: Path) -> None:
    page = visitor.new_page()  # a refused request is an error in the console
    page.goto(f"{server}/logs.html")
    page.get_by_role("button", name="Open map").first.click()
    await_true(page, "() => window.gridbloom && gridbloom.cells().free > 50")
    panel = open_group(page, "Localize")
    panel.get_by_label("Mapped along").select_option("true")
    panel.get_by_role("button", name="Use this map").click()
    expect(panel.get_by_role("button", name="Find the robot")).to_be_enabled()
    # A yaml with a wrong value and one with a wrong name; one that is right keeps what is of no use here.
    panel.get_by_text("Parameters of the filter").click()
    for lines, said in (
        (["z_hit: .nan"], "(z_hit) must be a finite number"),
        (["z_hot: 0.5"], "declares no parameter 'z_hot' (did you mean 'z_short'?)"),
        (["z_hit: 0.7", "scan_topic: front"], "Without effect here, and kept where you save: scan_topic."),
    ):
        panel.get_by_label("Yaml of an AMCL").set_input_files(amcl_yaml(tmp_path, *lines))
        expect(panel.get_by_text(said)).to_be_visible()
    with page.expect_download() as download:
        panel.get_by_role("button", name="Save as AMCL yaml").click()
    text = download.value.path().read_text()
    assert "    scan_topic: front\n" in text
    assert "    z_hit: 0.7\n" in text
    # A pose outside the map.
    panel.get_by_text("At a pose").click()
    for label in ("x (m)", "y (m)"):
        panel.get_by_label(label).fill("900")
        panel.get_by_label(label).press("Tab")
    panel.get_by_role("button", name="Find the robot").click()
    expect(panel.get_by_text("The pose (900, 900) m is outside the map, which goes from")).to_be_visible()
    # A map without free cells: an image that is all black.
    (tmp_path / "full.pgm").write_bytes(b"P5\n20 20\n255\n" + bytes(400))
    (tmp_path / "full.yaml").write_text(
        "image: full.pgm\nresolution: 0.1\norigin: [0, 0, 0]\nnegate: 0\noccupied_thresh: 0.65\nfree_thresh: 0.2\n"
    )
    panel.locator(".choice-option", has_text="Map files").click()
    panel.locator("input[type=file][multiple]").set_input_files([tmp_path / "full.yaml", tmp_path / "full.pgm"])
    expect(panel.get_by_text("full.yaml")).to_be_visible()
    panel.get_by_text("Anywhere").click()
    panel.get_by_role("button", name="Find the robot").click()
    expect(panel.get_by_text("The map has no free cells")).to_be_visible()
