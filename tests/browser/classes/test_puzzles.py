"""Puzzles in Chromium: one solved from start to end, one made in two clicks and shared, one solved by a class."""

from __future__ import annotations

import pytest
from playwright.sync_api import BrowserContext, Locator, Page, expect

from tests.browser.conftest import standing_world
from tests.browser.looking import await_map, open_group, until
from tests.marks import also_long


def test_a_puzzle_is_solved_from_start_to_end(page: Page, server: str) -> None:
    page.goto(f"{server}/puzzles.html")
    page.get_by_role("button", name="Open The closed doors").click()
    await_map(page)
    case = page.get_by_role("tabpanel", name="Case")
    score = page.locator(".case-score")
    expect(score).to_have_text("0 of 100 points")

    page.set_viewport_size({"width": 1280, "height": 720})
    for place in (case.get_by_role("radio").first, case.get_by_role("button", name="This is the cause")):
        expect(place).to_be_in_viewport(ratio=0.99)
    case.get_by_role("radio", name="The hit window is too wide").check()
    case.get_by_role("button", name="This is the cause").click()
    expect(case.get_by_role("radio", name="The hit window is too wide – no")).to_be_disabled()
    case.get_by_role("button", name="Show a hint (−10 points)").click()
    expect(case.get_by_role("listitem")).to_have_count(1)
    case.get_by_role("radio", name="The cells are too large").focus()
    page.keyboard.press("Space")
    page.keyboard.press("Enter")  # by keyboard alone
    expect(score).to_have_text("20 of 100 points")

    page.get_by_role("button", name="Check the map").first.click()
    expect(case.get_by_text("Repaired 0 %: no better than at first; it is solved at 90 %.")).to_be_visible()
    page.evaluate("() => gridbloom.connection.store.setParameter('resolution', 0.05)")
    page.wait_for_function("() => gridbloom.connection.store.map.peek()?.geometry.resolution === 0.05")
    page.set_viewport_size({"width": 390, "height": 844})
    page.get_by_role("tab", name="Settings").click()
    check = page.get_by_role("tabpanel", name="Settings").get_by_role("button", name="Check the map")
    expect(check).to_be_in_viewport(ratio=0.99)
    check.click()
    expect(case.get_by_role("heading", name="Solved: 80 of 100 points")).to_be_visible()  # though Settings were open
    expect(case.get_by_role("button", name="Next: The thick walls")).to_be_visible()
    link = case.get_by_role("link", name="Its section of the lecture")
    expect(link).to_have_attribute("href", "/lecture.html#resolution")
    page.get_by_role("button", name="All puzzles").first.click()
    expect(page.get_by_text("Solved in this browser: 1 of")).to_be_visible()


#: Of each puzzle the answer, and what repairs its map: controls, and the option or the value in its unit to be set.
SOLUTIONS: dict[str, tuple[str, dict[str, str | float]]] = {
    "doorway": ("The cells are too large", {"Resolution": 0.05}),
    "thick": ("The hit window is too wide", {"Hit window": 0.0}),
    "arcs": ("Beams without a return are counted as hits", {"Max range": 3.9}),
    "mirror": ("The beams are read in the wrong order", {"Mount turned over": "on"}),
    "worn": ("The poses come from odometry, which drifts", {"Poses from": "cameras"}),
    "bumped": ("The sensor is mounted at a different angle than stated", {"Mount yaw": 0.19}),
    "ghost": ("Something was moved, and the cells cannot forget it", {"Clamp": "on"}),
    "lunch": ("The origin of the grid changed during the log", {"Poses from": "cameras"}),
    "visitors": ("Somebody walked through the scans", {"Miss increment": -0.4, "Lower clamp": -6.0}),
    "leak": ("Polished walls reflect the beams away", {"No return": "ignore"}),
    "offset": ("The sensor is mounted at a different place than stated", {"Mount forward": -0.42}),
    "lag": ("The clocks of the scans and of the poses differ", {"Time offset": -0.55}),
    "integers": ("Coordinates below zero are truncated instead of rounded down", {"Poses from": "cameras"}),
    "torn": ("All beams of a scan are placed at one pose", {"Deskew": "on"}),
    "cones": ("A cone is treated as a thin beam", {"Inverse sensor model": "sonar cone", "Hit window": 0.2}),
    "collision": ("An obstacle is not at the height of the laser", {}),
}


def test_all_puzzles_have_a_solution_here(context: BrowserContext, server: str) -> None:
    assert {one["name"] for one in context.request.get(f"{server}/api/puzzles").json()["puzzles"]} == set(SOLUTIONS)


@pytest.mark.parametrize("name", ["worn", "arcs", *also_long(*sorted(SOLUTIONS.keys() - {"worn", "arcs"}))])
def test_each_puzzle_is_solved_by_its_own_repair(page: Page, server: str, name: str) -> None:
    cause, repair = SOLUTIONS[name]
    if name == "arcs":
        page.set_viewport_size({"width": 390, "height": 844})
    page.goto(f"{server}/puzzles.html?puzzle={name}")
    case = page.get_by_role("tabpanel", name="Case")
    case.get_by_role("radio", name=cause, exact=True).check()
    case.get_by_role("button", name="This is the cause").click()
    expect(case.get_by_text("That is the cause.").or_(case.get_by_role("heading", name="Solved")).first).to_be_visible()
    solved = case.get_by_role("heading", name="Solved: 100 of 100 points")
    if repair:
        check = case.get_by_role("button", name="Check the map")
        check.click()
        expect(case.get_by_text("Repaired 0 %: no better than at first; it is solved at 90 %.")).to_be_visible()
        for label, value in repair.items():  # what it takes is there already
            repaired_with(case, label, value)

        def is_solved() -> bool:  # a check may come before the server has the value
            if check.count() and check.is_enabled():
                check.click()
            return solved.is_visible()

        until("the puzzle to be solved", is_solved)
    expect(solved).to_be_visible()


def repaired_with(case: Locator, label: str, value: str | float) -> None:
    """Set one control of a repair as a visitor does."""
    if isinstance(value, float):
        field = case.get_by_role("spinbutton", name=f"{label}, as a number")
        expect(field).to_be_in_viewport()
        field.fill(str(value))
        field.press("Enter")
        return
    of_label = {"name": label, "exact": True}
    switch = case.get_by_role("switch", **of_label)  # type: ignore[arg-type]
    choice = case.get_by_role("combobox", **of_label)  # type: ignore[arg-type]
    options = case.get_by_role("radiogroup", **of_label)  # type: ignore[arg-type]
    expect(switch.or_(choice).or_(options)).to_be_in_viewport()
    if switch.count():
        switch.click()
    elif choice.count():
        choice.select_option(label=value)
    else:
        options.get_by_role("radio", name=value).click()


def test_a_puzzle_is_made_in_the_lab_and_given_to_a_class(
    page: Page, context: BrowserContext, visitor: BrowserContext, server: str
) -> None:
    page.goto(f"{server}/lab.html?session={standing_world(context, server)}")
    await_map(page)
    open_group(page, "Share")
    page.get_by_role("button", name="Make a puzzle").click()
    page.get_by_label("Fault to find").select_option("beam_order")
    page.get_by_role("button", name="Create the link").click()
    address = page.get_by_label("Address of the puzzle").input_value()
    solver = visitor.new_page()
    solver.goto(address)
    await_map(solver)
    expect(solver.get_by_role("radio", name="The beams are read in the wrong order")).to_be_visible()

    page.goto(f"{server}/puzzles.html")
    page.get_by_role("button", name="Class", exact=True).click()
    code = page.locator(".class-code-small").text_content() or ""
    page.get_by_role("dialog").get_by_role("button", name="Close").click()
    page.get_by_role("region", name="Your puzzles").get_by_role("button", name="Give to the class").first.click()
    solver.goto(f"{server}/class/{code}")
    solver.get_by_role("link", name="Solve the puzzle").click()
    await_map(solver)
    solver.get_by_role("radio", name="The beams are read in the wrong order").check()
    solver.get_by_role("button", name="This is the cause").click()
    board = page.get_by_role("region", name="Puzzle of the class")
    expect(board.get_by_role("status")).to_have_text("0 of 1 solved")
    expect(board.get_by_role("listitem")).to_have_count(0)  # it covers one line until it is unfolded
    board.get_by_role("button", name="Each follower").click()
    expect(board.get_by_role("listitem")).to_contain_text("cause named, repaired 0 %")
    solver.get_by_role("button", name="Back to the class").click()
    expect(solver.get_by_role("heading", name="You are in the class")).to_be_visible()
    board.get_by_role("button", name="End the puzzle").click()
    expect(board).to_have_count(0)
    # the class ends during an attempt
    page.get_by_role("region", name="Your puzzles").get_by_role("button", name="Give to the class").first.click()
    solver.get_by_role("link", name="Solve the puzzle").click()
    await_map(solver)
    failed: list[str] = []
    solver.on("response", lambda answer: failed.append(answer.url) if answer.status == 404 else None)
    page.get_by_role("button", name="End …").click()
    page.get_by_role("button", name="End and delete results").click()
    expect(solver.get_by_text("The class has ended, and with it this attempt.")).to_be_visible()
    solver.evaluate("() => fetch('/livez')")  # what was asked before has been answered
    assert failed == []
