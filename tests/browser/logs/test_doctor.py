"""The log doctor on the log page: no findings on a clean log, and findings that lead to their scans."""

from __future__ import annotations

import re

from playwright.sync_api import Locator, Page, expect

from tests.browser.looking import await_true, open_group, open_sample


def opened_sample(page: Page, server: str) -> None:
    open_sample(page, server)
    open_group(page, "Overview")
    expect(page.get_by_role("region", name="Log doctor")).to_be_visible()


def test_a_clean_run_is_well_and_a_drifting_one_is_not(page: Page, server: str) -> None:
    opened_sample(page, server)
    doctor = page.get_by_role("region", name="Log doctor")
    # The log opens on what it is and what happened in it; the examination begins by itself.
    facts = page.locator(".log-facts")
    expect(facts).to_contain_text("ground truth")
    expect(doctor).to_contain_text("No problems found. Poses: ground truth.")
    expect(doctor.get_by_role("button")).to_have_count(0)  # nothing more to show
    open_group(page, "Trajectories")
    page.get_by_label("Poses from").get_by_text("wheel odometry").click()
    # It goes on while another group is open, and its tab tells how much it found.
    expect(page.get_by_role("tab", name="Log", exact=False).first.locator(".dock-badge")).to_have_text(
        re.compile("[1-9]")
    )
    open_group(page, "Overview")
    finding = doctor.locator('[data-check="walls.drift"]')
    expect(finding).to_contain_text(re.compile("The poses (may )?drift"))
    link = finding.get_by_role("button", name=re.compile(r"Go to \d+:\d\d\.\d{3}")).first
    minutes, seconds = link.inner_text().split(":")
    page.evaluate("() => gridbloom.connection.store.send({ type: 'pause' })")
    link.click()
    await_true(
        page,
        "at => Math.abs(window.gridbloom.connection.store.frame.value?.stamp - at) < 0.002",
        arg=60 * int(minutes) + float(seconds),  # the scan of that time is the newest in the map
    )
    is_cancelled_and_offered_again(page, doctor)


def is_cancelled_and_offered_again(page: Page, doctor: Locator) -> None:
    page.set_viewport_size({"width": 1024, "height": 768})  # where the title has no room to spare
    page.route("**/doctor?*", lambda _: None)  # the answer never comes
    open_group(page, "Trajectories")
    page.get_by_label("Poses from").get_by_text("ground truth").click()
    note = page.locator(".viewer-head .examination-note")  # in view, whichever group is open
    expect(note).to_contain_text("Examining …")
    open_group(page, "Overview")
    picture = page.locator(".viewer .picture").first
    with_note = picture.bounding_box()
    doctor.get_by_role("button", name="Cancel the examination").click()
    expect(note).to_have_count(0)
    assert picture.bounding_box() == with_note
    expect(doctor).to_contain_text("Cancelled.")
    page.unroute("**/doctor?*")
    doctor.get_by_role("button", name="Examine this log").click()
    expect(doctor).to_contain_text("No problems found. Poses: ground truth.")
