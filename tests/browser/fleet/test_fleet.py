"""The page of the fleet in Chromium: all logs mapped by one press, their maps, findings and failures."""

from __future__ import annotations

import re

import pytest
from playwright.sync_api import Page, expect

from mapper.diagnosis.examination import CHECKS
from server.fleet import Result
from server.fleet.page import page as page_of
from server.library.processing.fleet.fleet_job import FleetFinding, MapFacts
from tests.browser.looking import await_true
from tests.browser.pages.test_axe import violations


@pytest.mark.usefixtures("two_logs")
@pytest.mark.parametrize("context", ["phone"], indirect=True)
def test_one_press_maps_all_logs(page: Page, server: str) -> None:
    page.goto(f"{server}/logs.html")
    page.get_by_role("link", name="Map all logs").click()
    yard = page.locator(".fleet-card", has_text="fleet-yard.log")
    empty = page.locator(".fleet-card", has_text="fleet-empty.log")
    expect(yard).to_contain_text("Not mapped yet")
    page.get_by_role("button", name="Map").click()
    expect(yard).to_contain_text("40 scans")
    expect(empty).to_contain_text("The log holds no scans")
    yard.scroll_into_view_if_needed()
    await_true(page, "() => [...document.images].some((one) => one.alt.includes('fleet-yard') && one.naturalWidth > 0)")
    page.get_by_role("searchbox", name="Search logs").fill("fleet")
    page.get_by_role("radio", name="Failed").check()
    expect(page.locator(".fleet-card")).to_have_count(1)
    expect(page.get_by_text("1 log found")).to_be_visible()
    page.get_by_role("radio", name="All").check()
    yard.get_by_role("link").click()
    expect(page).to_have_url(re.compile("log=folder-"))


@pytest.mark.usefixtures("two_logs")
def test_all_logs_are_mapped_again_with_other_options(page: Page, server: str) -> None:
    page.goto(f"{server}/fleet.html")
    yard = page.locator(".fleet-card", has_text="fleet-yard.log")
    page.get_by_role("button", name="Map").click()
    expect(yard).to_contain_text("40 scans")
    expect(yard).not_to_contain_text("With")
    page.get_by_text("Options", exact=True).click()
    page.get_by_label("Sensor").fill("FLASER")
    page.get_by_label("Mount yaw").fill("90")
    page.get_by_role("button", name="Map all with these options").click()
    expect(yard).to_contain_text("With sensor FLASER, mount 0 m, 0 m, 90°")
    expect(yard).to_contain_text("40 scans")
    page.get_by_label("Poses").fill("gps")
    page.get_by_role("button", name="Map all with these options").click()
    expect(yard).to_contain_text("no trajectory 'gps'")


def test_drift_and_first_finding_are_shown_and_choose_and_order_the_maps(page: Page, server: str) -> None:
    def log(name: str, drift_m: float | None, *checks: str) -> dict[str, object]:
        findings = [{"check": check, "sentence": f"This is {check}.", "possible": False} for check in checks]
        size: dict[str, object] = {"scans": 40, "beams": 3, "rows": 10, "cols": 10, "resolution": 0.1, "contrast": 0.5}
        work: dict[str, object] = {"trajectory": "odom", "picture": False, "cpu_s": 1.0, "seconds": 1.0, "runs": 1}
        facts = size | work | {"findings": findings, "drift_m": drift_m}
        return {"id": f"id-{name}", "name": name, "state": "done", "fraction": 0.0, "error": None, "facts": facts} | {
            "options": ""
        }

    logs = [log("a", 0.125), log("b", 1.5, "walls.drift", "clock.gap"), log("c", None, "clock.gap")]
    counts = dict.fromkeys(("none", "queued", "running", "failed"), 0) | {"done": len(logs)}
    answer = {"revision": 1, "whole": True, "workers": 1, "cluster": None, "counts": counts, "logs": logs}
    page.route("**/api/fleet?*", lambda route: route.fulfill(json=answer))
    page.goto(f"{server}/fleet.html")
    cards, names = page.locator(".fleet-card"), page.locator(".fleet-card h2")
    expect(names).to_have_text(["a", "b", "c"])
    expect(cards).to_contain_text(["No findings", "Drift 1.50 m", "Drift not measured"])
    drifted = cards.nth(1)
    expect(drifted.get_by_text("This is walls.drift.")).to_be_visible()
    expect(drifted.get_by_text("This is clock.gap.")).to_be_hidden()
    drifted.get_by_text("and 1 more").click()
    expect(drifted.get_by_text("This is clock.gap.")).to_be_visible()
    page.get_by_role("combobox", name="Order").select_option("most drift first")
    expect(names).to_have_text(["b", "a", "c"])
    page.get_by_role("combobox", name="Drift").select_option("drift of 0.1 m or more")
    expect(names).to_have_text(["b", "a"])
    page.get_by_role("combobox", name="Drift").select_option("any drift")
    page.get_by_role("radio", name="gap in the recording (1)").check()
    expect(names).to_have_text(["c"])
    expect(page.get_by_text("1 log found")).to_be_visible()
    expect(cards.get_by_role("link")).to_have_attribute("href", "/logs.html?log=id-c")


def test_the_page_of_the_command_orders_and_finds_its_maps(page: Page, server: str) -> None:
    def one(name: str, drift_m: float | None, *sentences: str) -> Result:
        findings = tuple(FleetFinding("walls.drift", sentence, possible=True) for sentence in sentences)
        facts = MapFacts(
            scans=3, beams=2, trajectory="odom", rows=10, cols=20, resolution=0.05, contrast=0.5, drift_m=drift_m,
            findings=findings, picture=False, cpu_s=0.1,
        )  # fmt: skip
        return Result(name, f"/logs/{name}", 1.0, 1, facts)

    text = page_of([one("a.log", 0.1, "The poses drift."), one("b.log", 2.0), one("c.log", None)], 3, running=False)
    page.route("**/fleet-of-the-command", lambda route: route.fulfill(content_type="text/html", body=text))
    page.goto(f"{server}/fleet-of-the-command")
    names = page.locator(".wall > li:visible .text a")
    expect(names).to_have_text(["a.log", "b.log", "c.log"])
    page.get_by_role("combobox", name="Order").select_option("most drift first")
    expect(names).to_have_text(["b.log", "a.log", "c.log"])
    page.get_by_role("combobox", name="Drift").select_option("drift of 0.1 m or more")
    page.reload()
    expect(names).to_have_text(["b.log", "a.log"])
    page.get_by_role("searchbox", name="Search logs").fill("possibly drift")
    expect(names).to_have_text(["a.log"])
    expect(page.get_by_role("status")).to_have_text("1 found")
    assert violations(page) == []


def test_each_finding_of_the_doctor_is_named_in_words(page: Page, server: str) -> None:
    checks = sorted({name for check in CHECKS for name in check.names})
    facts = {"scans": 40, "beams": 3, "rows": 10, "cols": 10, "resolution": 0.1, "contrast": 0.5, "drift_m": None}
    work = {"trajectory": "odom", "picture": False, "cpu_s": 1.0, "seconds": 1.0, "runs": 1}
    logs = [
        {"id": f"id-{check}", "name": check, "state": "done", "fraction": 0.0, "error": None}
        | {"facts": facts | work | {"findings": [{"check": check, "sentence": "It is.", "possible": False}]}}
        for check in checks
    ]
    counts = dict.fromkeys(("none", "queued", "running", "failed"), 0) | {"done": len(logs)}
    answer = {"revision": 1, "whole": True, "workers": 1, "cluster": None, "counts": counts, "logs": logs}
    page.route("**/api/fleet?*", lambda route: route.fulfill(json=answer))
    page.goto(f"{server}/fleet.html")
    options = page.get_by_role("combobox", name="First finding").locator("option")
    expect(options).to_have_count(len(checks) + 1)
    assert [text for text in options.all_inner_texts() if "." in text] == []


def test_without_logs_the_page_says_what_it_does_and_shows_the_sample(page: Page, server: str) -> None:
    counts = dict.fromkeys(("none", "queued", "running", "done", "failed"), 0)
    nothing: dict[str, object] = {
        "revision": 0,
        "whole": True,
        "workers": 1,
        "cluster": None,
        "counts": counts,
        "logs": [],
    }
    page.route("**/api/fleet?*", lambda route: route.fulfill(json=nothing))  # other tests put logs into the folder
    page.goto(f"{server}/fleet.html")
    start = page.get_by_role("region", name="Without logs")
    expect(start.get_by_text("There are no logs with scans here yet.")).to_be_visible()
    await_true(
        page, "() => [...document.images].some((one) => one.alt === 'Map of the sample' && one.naturalWidth > 0)"
    )
    expect(start).to_contain_text("600 scans")
    expect(start.get_by_role("link", name="Add logs")).to_have_attribute("href", "/logs.html")
    start.get_by_role("link", name="A simulated office (sample)").click()
    expect(page).to_have_url(re.compile("log=sample-office"))
