"""The lecture's figure of two scans in real Chromium: it is dragged, snaps, and shows its error."""

from __future__ import annotations

import re

from playwright.sync_api import Page, expect

from tests.browser.lecturing import open_section
from tests.browser.looking import drag

METRES_WIDE = 6.4  #: of the picture


def test_a_scan_dragged_near_its_pose_snaps(page: Page, server: str) -> None:
    section = open_section(page, server, "matching")
    result = section.locator("figcaption")
    expect(result).to_contain_text("error 70.7 cm, 15.0°")
    scan = section.get_by_role("slider", name="Position of the moving scan")
    metre = section.locator(".stage").first.evaluate("e => e.clientWidth") / METRES_WIDE
    drag(page, scan, -0.45 * metre, -0.4 * metre)
    expect(result).to_contain_text("Snapped.")
    found = re.search(r"error ([\d.]+) cm, ([\d.]+)°", result.inner_text())
    assert found is not None
    assert float(found[1]) < 5
    assert float(found[2]) < 2
    # Turned by 70° with the keys, the scan is out of reach of the snap.
    section.get_by_role("slider", name="Heading of the moving scan").focus()
    for _ in range(14):
        page.keyboard.press("ArrowUp")
    expect(result).not_to_contain_text("Snapped.")
    # In a corridor the motion along the walls is not known.
    section.get_by_label("Scans of").select_option("corridor")
    section.get_by_role("button", name="To the end").click()
    expect(result).to_contain_text("Degenerate")
