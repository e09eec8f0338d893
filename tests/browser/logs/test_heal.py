"""Healing the poses of a drifting log on its page: pressed, watched, compared, questioned, changed by hand."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.browser.drifting import drifting_ring
from tests.browser.looking import SECONDS, await_true, frame, open_group, settled_digest, until
from tests.browser.pages.test_axe import violations


def opened(page: Page, server: str, name: str, data: bytes) -> None:
    """Upload a log and open its map, which does not play: drawing it takes more time than healing it."""
    page.goto(f"{server}/logs.html")
    page.locator("input[type=file]").set_input_files({"name": name, "mimeType": "text/plain", "buffer": data})
    expect(page.get_by_role("tab", name="Heal")).to_be_visible()
    # While it plays, the doctor waits.
    count = frame(page)["count"]
    page.evaluate("count => gridbloom.connection.store.send({ type: 'step', scans: count })", count)


def facts(panel: Locator) -> tuple[float, float]:
    """The sharpness before and after."""
    cell = panel.locator('dd[data-figure="sharpness"]')
    return float(str(cell.get_attribute("data-before"))), float(str(cell.get_attribute("data-after")))


def drift_is_healed(page: Page, server: str, name: str, data: bytes) -> None:
    opened(page, server, name, data)
    # The examination begins by itself; the remedy is offered beside the log's name, and nothing moves for it.
    stage = page.locator(".viewer-map")
    before_offer = stage.bounding_box()
    offer = page.locator(".correction-offer")
    expect(offer).to_contain_text("The poses drift")
    assert stage.bounding_box() == before_offer
    # The doctor's finding offers it too.
    doctor = open_group(page, "Overview")
    finding = doctor.locator('[data-check="walls.drift"]')
    expect(finding).to_contain_text("gridbloom slam")
    expect(finding.get_by_role("button", name="Heal its poses")).to_be_visible()
    offer.get_by_role("button", name="Heal its poses").click()
    expect(offer).to_have_count(0)
    panel = page.get_by_role("region", name="Heal its poses")
    expect(panel.get_by_role("progressbar")).to_be_visible()
    # The map fills in along the poses so far, while the job runs.
    until(
        "a part of the map along corrected poses",
        lambda: page.evaluate(
            "() => { const s = gridbloom.connection.store;"
            " return s.trajectory.peek()?.name === 'SLAM' && s.frame.peek().index > 0 }"
        ),
    )
    expect(panel).to_contain_text("Healed", timeout=5 * SECONDS * 1000)
    before, after = facts(panel)
    assert after > before
    expect(panel).to_contain_text(re.compile(r"[1-9]\d* loops?"))
    await_true(
        page, "() => { const f = gridbloom.connection.store.frame.peek(); return f.index === f.count && !f.playing }"
    )
    panel.get_by_role("button", name="Compare with before").click()
    expect(page.get_by_role("slider", name=re.compile("divider", re.IGNORECASE))).to_be_visible()

    graph = page.get_by_role("region", name="Pose graph")
    graph.get_by_text("Loops, the worst first").click()
    loops = graph.get_by_role("list", name="Loops", exact=True)
    loops.get_by_role("button").first.click()
    selected = page.get_by_role("region", name="Selected loop")
    expect(selected).to_contain_text(re.compile(r"Residual\s*[\d.]+ σ"))
    assert page.evaluate("() => gridbloom.connection.store.scanPair.peek().points.aligned.length") > 10
    graph.get_by_role("button", name="Why no loop at the robot?").click()
    why = page.get_by_role("region", name="Why no loop closed here")
    expect(why).to_contain_text(re.compile("The robot was here"))
    # Without any loop the map is another one, and as SLAM left it, it is the one from before.
    healed = settled_digest(page)
    count = loops.get_by_role("button").count()
    loops.get_by_role("button").first.click()
    selected.get_by_role("button", name="Remove this loop").click()
    expect(loops.get_by_role("button")).to_have_count(count - 1 if count < 60 else 60)
    graph.get_by_role("button", name="As SLAM left it").click()
    expect(loops.get_by_role("button")).to_have_count(count)
    assert settled_digest(page) == healed
    # The layout for it: residuals of the graph, and the relative error of the wheels, not of two equal paths.
    page.get_by_label("Layout", exact=True).select_option("Diagnosis")
    residuals = page.get_by_role("region", name="Residuals")
    expect(residuals.get_by_role("img", name=re.compile("odometry residual distance: 0.00 to"))).to_be_visible()
    expect(residuals.get_by_role("img", name=re.compile("relative translation error over time"))).to_be_visible()
    expect(residuals).to_contain_text(re.compile("scan poses against SLAM, over 1 m"))
    assert violations(page, ".view-stage") == []


def test_a_drifting_log_is_healed(page: Page, server: str) -> None:
    drift_is_healed(page, server, "ring.log", drifting_ring())


@pytest.mark.long
def test_intel_is_healed(page: Page, server: str, data_file: Callable[[str], Path]) -> None:
    drift_is_healed(page, server, "intel.log.gz", data_file("carmen/intel.log.gz").read_bytes())
