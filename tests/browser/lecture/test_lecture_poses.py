"""The lecture's figures of drift, of the most probable pose and of a pose graph, in real Chromium."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Locator, Page, expect

from tests.browser.lecturing import open_section
from tests.browser.looking import drag, until


def metres(caption: Locator, pattern: str) -> float:
    found = re.search(pattern, caption.inner_text())
    assert found is not None, caption.inner_text()
    return float(found[1])


def test_a_loop_closes_the_graph_a_wrong_one_bends_it_and_a_kernel_refuses_it(page: Page, server: str) -> None:
    section = open_section(page, server, "graph")
    caption = section.locator("figcaption")

    def off() -> float:
        return metres(caption, r"error of the poses: ([\d.]+) m")

    until("the figure", lambda: caption.count() > 0)
    drifted = off()
    assert drifted > 0.6
    # A pose that is dragged takes its neighbours along, and goes back when it is let go.
    pose, neighbour = (section.get_by_role("slider", name=f"Pose {k}", exact=True) for k in (9, 10))
    before = neighbour.get_attribute("aria-valuetext")
    pose.focus()
    page.keyboard.down("ArrowUp")
    expect(neighbour).not_to_have_attribute("aria-valuetext", before or "")
    page.keyboard.up("ArrowUp")
    expect(neighbour).to_have_attribute("aria-valuetext", before or "")
    section.get_by_role("switch", name="Loop", exact=True).check()
    until("the loop to close", lambda: off() < 0.3)
    section.get_by_role("switch", name="Wrong loop").check()
    until("the wrong loop to bend the graph", lambda: off() > 1.0)
    section.get_by_text("Geman–McClure").click()
    until("the kernel to refuse it", lambda: off() < 0.3)
    # The graph still relaxes for some frames.
    until("no weight of the wrong loop", lambda: metres(caption, r"wrong loop: [\d.]+ σ, weight (\d\.\d+)") < 0.01)
    until("the weight of the right loop", lambda: metres(caption, r"right loop: [\d.]+ σ, weight (\d\.\d+)") > 0.8)


@pytest.mark.long
def test_the_noise_of_the_odometry_smears_the_map_and_matching_does_not(page: Page, server: str) -> None:
    section = open_section(page, server, "odometry")
    caption = section.locator("figcaption")
    expect(caption).to_contain_text("corrected")
    expect(caption.locator(".drift-matched")).not_to_have_text("…")  # all scans are matched
    raw, corrected = metres(caption, r"([\d.]+) m by odometry"), metres(caption, r"odometry, ([\d.]+) m corrected")
    assert corrected < 0.3 < raw
    section.get_by_role("slider", name="Heading error").first.focus()
    for _ in range(4):
        page.keyboard.press("ArrowRight")
    until("more drift", lambda: metres(caption, r"([\d.]+) m by odometry") > raw)


@pytest.mark.long
def test_the_odometry_chooses_among_places_that_look_alike(page: Page, server: str) -> None:
    section = open_section(page, server, "probable")
    caption = section.locator("figcaption")
    expect(caption).to_contain_text(re.compile(r"\b[0-9] cm off"))
    section.get_by_text("with doors", exact=True).click()
    diamond = section.get_by_role("slider", name="Position by odometry")
    metre = section.locator(".stage").evaluate("e => e.clientWidth") / 9.6
    drag(page, diamond, 0.9 * metre, 0)
    until("the next door", lambda: metres(caption, r"(\d+) cm off") > 150)
    drag(page, diamond, -1.8 * metre, 0)
    until("the right door", lambda: metres(caption, r"(\d+) cm off") < 10)
    section.get_by_text("bare", exact=True).first.click()
    says = metres(caption, r"says ([\d.]+) m")
    until("what the odometry says", lambda: abs(metres(caption, r"probable \(disc\) is ([\d.]+) m") - says) < 0.06)
