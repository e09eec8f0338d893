"""A class in Chromium: a lecturer, followers, a question and its reveal, a copy, a broken connection, the end.

Four followers and two predictions of the lecture in ``make test``, ten and all in ``make test-long``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from functools import partial
from urllib.parse import urlsplit

import numpy as np
import pytest
from playwright.sync_api import Browser, BrowserContext, Locator, Page, expect

from tests.browser.conftest import standing_world
from tests.browser.cutting_proxy import cutting_proxy
from tests.browser.lecturing import never_idle
from tests.browser.looking import await_map, await_true, map_digest, open_group, settled_digest, until
from tests.browser.pages.test_axe import nothing_wrong
from tests.browser.pages.test_targets import small
from tests.browser.visits import WatchedPage, visiting
from tests.marks import also_long

CELL = [3.5, 2.5]


@pytest.fixture
def phones(browser: Browser, server: str, request: pytest.FixtureRequest) -> Iterator[list[Page]]:
    """Return the pages of as many followers as an indirect parameter says, each in a browser of its own."""
    with ExitStack() as stack:
        watched = [
            WatchedPage(stack.enter_context(visiting(browser, server, viewport={"width": 390, "height": 844})), server)
            for _ in range(request.param)
        ]
        yield [one.page for one in watched]
        assert [one.problems for one in watched] == [[]] * len(watched)


def opened(page: Page, server: str, path: str) -> str:
    """Open a class on a page; return its code."""
    page.goto(f"{server}{path}")
    page.get_by_role("button", name="Class", exact=True).click()
    code = page.locator(".class-code-small").text_content() or ""
    expect(page.get_by_role("img", name="QR code of")).to_have_js_property("complete", value=True)
    page.get_by_role("dialog").get_by_role("button", name="Close").click()
    return code


def shows_cell(page: Page) -> bool:
    """Whether the selected cell of a page is the lecturer's."""
    return bool(page.evaluate("() => gridbloom.connection.store.pinned.peek()") == CELL)


def ended(page: Page) -> None:
    page.get_by_role("button", name="End …").click()
    page.get_by_role("button", name="End and delete results").click()
    expect(page.get_by_role("complementary", name="Class")).to_have_count(0)


@pytest.mark.parametrize("phones", [4, *also_long(10)], indirect=True)
def test_followers_answer_and_two_of_them_follow_into_the_lab(
    page: Page, context: BrowserContext, phones: list[Page], server: str
) -> None:
    followers = len(phones)
    result = f"{followers} answered. Yes: {followers - 3}; No: 3"
    code = opened(page, server, "/logs.html")
    for i, phone in enumerate(phones):
        if i:
            phone.goto(f"{server}/class/{code}")  # as by the QR code
        else:
            phone.goto(f"{server}/join")
            nothing_wrong(phone)
            assert small(phone) == []
            slip = code[:5] + ("A" if code[5] != "A" else "B")
            phone.get_by_label("Code").fill(slip)
            phone.get_by_role("button", name="Join").click()
            expect(phone.get_by_role("alert")).to_contain_text("There is no class with this code.")
            expect(phone.get_by_label("Code")).to_have_value(slip)  # what was typed wrong can be seen
            phone.get_by_label("Code").fill(f"{code[:3]} {code[3:]}".lower())
            phone.get_by_role("button", name="Join").click()
        expect(phone.get_by_role("heading", name="You are in the class")).to_be_visible()
    lecturers = page.get_by_role("complementary", name="Class")
    expect(lecturers).to_contain_text(f"{followers} here")

    # a poll that is made on the spot
    page.get_by_role("button", name="Ask", exact=True).click()
    form = page.get_by_role("dialog", name="Ask the class")
    form.get_by_role("textbox", name="Question").fill("Is the door open?")
    form.get_by_role("button", name="Ask", exact=True).click()
    for i, phone in enumerate(phones):
        phone.get_by_role("button", name="A Yes" if i < followers - 3 else "B No").click()
    expect(lecturers).to_contain_text(f"{followers} of {followers} answered")
    for one in (page, phones[0]):  # with the question on both
        nothing_wrong(one)
        assert small(one) == []
    expect(lecturers.get_by_role("list", name=result)).to_have_count(0)  # the lecturer's screen is projected
    page.get_by_role("button", name="Show answers").click()
    expect(lecturers.get_by_role("list", name=result)).to_be_visible()
    expect(phones[0].get_by_role("list", name=f"{followers} answered")).to_have_count(0)  # not before the reveal
    lecturers.get_by_role("button", name="Show the result").click()
    for phone in phones:
        expect(phone.get_by_role("list", name=result)).to_be_visible()
    page.get_by_role("button", name="Remove the question").click()

    # two follow into the lab, one of them late
    for phone in phones[2:]:
        phone.close()
    page.goto(f"{server}/lab.html?session={standing_world(context, server)}")
    await_map(page)
    first, late = phones[0], phones[1]
    expect(first).to_have_url(re.compile("/lab.html"))
    page.evaluate("() => { gridbloom.connection.store.pinned.value = [3.5, 2.5]; }")
    open_group(page, "Sensor")
    late.goto(f"{server}/class/{code}")
    for phone in (first, late):
        await_map(phone)
        until("the selected cell", partial(shows_cell, phone))
        expect(phone.get_by_role("tabpanel", name="Sensor", exact=True, include_hidden=True)).to_be_visible()
        expect(phone.get_by_text("Drag the coloured handles")).to_be_hidden()  # what it shows is the lecturer's
    # a follower's page sends nothing, and a copy is the follower's own
    scans = page.evaluate("() => gridbloom.connection.store.frame.peek().count")
    first.get_by_role("button", name="Try it yourself").click()
    expect(first.get_by_role("button", name="Back to the class")).to_be_visible()
    await_map(first)
    first.get_by_role("button", name="Play", exact=True).click()
    await_true(first, "scans => gridbloom.connection.store.frame.peek()?.count > scans", arg=scans)
    assert page.evaluate("() => gridbloom.connection.store.frame.peek().count") == scans
    first.get_by_role("button", name="Back to the class").click()
    until("the lecturer's world again", partial(shows_cell, first))
    ended(page)
    expect(first.get_by_role("complementary", name="Class")).to_contain_text("The class has ended.")


def test_the_question_of_a_slide_is_asked_and_a_phone_whose_connection_breaks_is_where_the_class_is(
    page: Page, visitor: BrowserContext, server: str
) -> None:
    never_idle(page)
    never_idle(visitor)
    code = opened(page, server, "/lecture.html")
    port = urlsplit(server).port or 0
    with cutting_proxy(port) as proxy:
        phone = visitor.new_page()  # not a watched one: a broken connection is an error in the console
        phone.goto(f"http://127.0.0.1:{proxy.port}/class/{code}")
        expect(phone).to_have_url(re.compile("/lecture.html"))
        page.get_by_role("button", name="Presentation mode").click()
        page.keyboard.press("Home")
        page.goto(f"{server}/lecture.html?present#cell/2")
        choice = phone.get_by_role("button", name="The ninth")
        expect(choice).to_be_disabled()  # an answer before the question would be lost
        expect(phone.get_by_text("Wait for the question.")).to_be_visible()
        page.get_by_role("button", name="Ask the class").click()
        expect(phone.get_by_text("Tap your answer.")).to_be_visible()
        choice.click()
        expect(choice).to_have_attribute("aria-pressed", "true")
        counted = page.get_by_role("complementary", name="Class")
        option = page.get_by_role("button", name="The ninth")
        expect(counted).to_contain_text("1 of 1 answered")
        expect(option).not_to_contain_text("1 answer")  # before the reveal only when it is wanted
        page.get_by_role("button", name="Show answers").click()
        expect(option).to_contain_text("1 answer")
        proxy.cut()
        expect(phone.get_by_role("complementary", name="Class")).to_contain_text("Connecting to the class")
        page.keyboard.press("ArrowRight")
        page.keyboard.press("ArrowRight")  # the answer of the slide reveals the result
        proxy.mend()
        expect(phone.get_by_role("list", name="1 answered.")).to_contain_text("right")
        expect(phone).to_have_url(re.compile("#cell/4$"))
        expect(phone.get_by_role("heading", name="After four hits of +0.85").first).to_be_visible()
        page.mouse.move(500, 300)
        expect(phone.locator(".class-pointer")).to_be_visible()
        phone.set_viewport_size({"width": 390, "height": 844})  # there the slide is laid out otherwise
        expect(phone.locator(".class-pointer")).to_be_hidden()
        page.keyboard.press("Shift+ArrowRight")
        expect(phone).to_have_url(re.compile("#cell-derivation"))
        expect(phone.locator(".class-pointer")).to_have_count(0)
    ended(page)


def test_the_map_of_a_log_is_followed_and_copied(page: Page, visitor: BrowserContext, server: str) -> None:
    code = opened(page, server, "/logs.html")
    phone = visitor.new_page()
    phone.goto(f"{server}/class/{code}")
    expect(phone.get_by_role("heading", name="You are in the class")).to_be_visible()
    page.locator(".log-card", has_text="sample").get_by_role("button", name="Open map").click()
    expect(phone).to_have_url(re.compile("/logs.html"))
    await_map(phone)

    def held(name: str) -> Callable[[], bool]:
        """Whether a value of the follower's page is that of the lecturer's page."""
        read = f"() => JSON.stringify(gridbloom.connection.store.{name})"
        return lambda: bool(phone.evaluate(read) == page.evaluate(read))

    # time, parameters, map, selected cell, visible part, explanation
    page.evaluate("""() => {
      const { store } = gridbloom.connection;
      store.send({ type: "pause" });
      store.send({ type: "seek", index: 30 });
      store.setParameter("range_max", 4);
      store.pinned.value = [3.5, 2.5];
      store.setView({ x: 3, y: 2, scale: 0.02 });
    }""")
    digest = settled_digest(page)
    until("the lecturer's map", lambda: map_digest(phone) == digest)
    for name in ("frame.peek().index", "mapping.values.peek()", "pinned.peek()"):
        until(name, held(name))
    until("the visible part", lambda: phone.evaluate("() => gridbloom.connection.store.view.peek().x") == 3)
    page.evaluate(
        "() => { const { store } = gridbloom.connection; store.explain(store.frame.peek().pose.slice(0, 2)); }"
    )
    why = phone.get_by_role("tabpanel", name="Why", include_hidden=True)
    expect(why.locator(".why-chart").first).to_be_visible()
    expect(phone.get_by_role("button", name="Ask for the robot")).to_have_count(0)
    nothing_wrong(phone)

    # a copy is the follower's own
    phone.get_by_role("button", name="Try it yourself").click()
    expect(phone.get_by_role("button", name="Back to the class")).to_be_visible()
    phone.get_by_role("tab", name="Poses").wait_for()
    until("the copied map", lambda: map_digest(phone) == digest)
    phone.evaluate("() => gridbloom.connection.store.setParameter('range_max', 2)")
    until("another map", lambda: map_digest(phone) != digest)
    assert settled_digest(page) == digest
    phone.get_by_role("button", name="Back to the class").click()
    until("the lecturer's map again", lambda: map_digest(phone) == digest)

    page.get_by_role("button", name="All logs").click()
    expect(phone.get_by_role("heading", name="You are in the class")).to_be_visible()
    ended(page)


#: Sections with a prediction below their figure, and the answer that it gives.
def beams_without_return() -> int:
    """Return how many of 180 beams from (2.4, 2.5) meet nothing within 5 m, or first the pane of glass.

    The hall is from (0.5, 0.5) to (9.1, 5.9), its pillar from (6.3, 3.9) to (6.9, 4.5), the glass at x = 3.9 up to
    y = 2.1: metres, as in the lesson.
    """
    x, y = 2.4, 2.5
    angle = np.radians(2.0) * np.arange(180)
    with np.errstate(divide="ignore", invalid="ignore"):
        inverse = 1 / np.stack([np.cos(angle), np.sin(angle)])
        walls = np.max(
            [(np.array([[0.5 - x], [0.5 - y]])) * inverse, (np.array([[9.1 - x], [5.9 - y]])) * inverse], axis=0
        )
        sides = np.sort(
            [np.array([[6.3 - x], [3.9 - y]]) * inverse, np.array([[6.9 - x], [4.5 - y]]) * inverse], axis=0
        )
        glass = (3.9 - x) * inverse[0]
    enters, leaves = sides[0].max(axis=0), sides[1].min(axis=0)
    pillar = np.where((enters <= leaves) & (enters > 0), enters, np.inf)
    nearest = np.minimum(walls.min(axis=0), pillar)
    at = y + glass * np.sin(angle)
    is_glass = (glass > 0) & (at >= 0.5) & (at <= 2.1) & (glass < nearest)
    return int(np.sum(is_glass | (nearest > 5)))


def first_number(text: str) -> float:
    """Return the first number in a text."""
    found = re.search(r"\d+(\.\d+)?", text)
    assert found, text
    return float(found[0])


def odometry_error(section: Locator) -> str:
    """Return the error that the figure itself states."""
    return f"{first_number(section.locator('.drift-raw').inner_text()):.1f} m"


def scans_of(section: Locator) -> float:
    """Return the number of scans that the figure of the kidnapped robot states."""
    return first_number(section.get_by_text(re.compile(r"^Scan \d+: ")).inner_text())


#: Of each prediction: the answer. Those whose figures draw random numbers state theirs beside the drawing.
PREDICTIONS = {
    "log-odds": "16 hits",  # the least n with 1 / (1 + 3ⁿ) < 2⁻²⁵
    "no-return": f"{beams_without_return()} beams",
    "resolution": "960 kB",  # 12 m × 8 m in cells of 2 cm, 4 bytes each
    "odometry": None,
    "kidnapping": None,
}


@pytest.mark.parametrize("sections", [("log-odds", "odometry"), *also_long(tuple(PREDICTIONS))], ids=["two", "all"])
def test_the_predictions_of_the_lecture_are_asked_of_the_class(
    page: Page, visitor: BrowserContext, server: str, sections: tuple[str, ...]
) -> None:
    never_idle(page)
    never_idle(visitor)
    code = opened(page, server, "/lecture.html")
    phone = visitor.new_page()
    phone.goto(f"{server}/class/{code}")
    expect(phone).to_have_url(re.compile("/lecture.html"))
    card = phone.get_by_role("region", name="Question to the class")
    for section in sections:
        answer = PREDICTIONS[section]
        page.goto(f"{server}/lecture.html#{section}")
        predict = page.locator(f"#{section}").get_by_role("region", name=re.compile("^Predict: "))
        predict.get_by_role("button", name="Ask the class").click()
        card.get_by_role("button", name="Answer", exact=True).click()
        expect(page.get_by_text("1 of 1 answered")).to_be_visible()
        expect(predict.locator("title")).to_have_count(0)  # no columns of the answers before the reveal
        expect(card.get_by_role("img", name="1 answered")).to_have_count(0)
        figure = page.locator(f"#{section} figure").first
        before = scans_of(figure) if section == "kidnapping" else 0
        predict.get_by_role("button", name="Show the result").click()
        expect(predict.get_by_role("status")).to_contain_text("It is ")
        expected = answer
        if section == "odometry":
            expected = odometry_error(figure)
        elif section == "kidnapping":
            expected = f"{scans_of(figure) - before:.0f} scans"
        expect(predict.get_by_role("status")).to_contain_text(f"It is {expected}.")
        until("the answer", partial(one_answer, predict))
        expect(card.get_by_role("img", name="1 answered.")).to_be_visible()
        expect(card.get_by_role("status")).to_contain_text("1 answered. ")
        nothing_wrong(page, f"#{section} .prediction")
        page.get_by_role("button", name="Remove the question").click()
        expect(card).to_have_count(0)
    ended(page)


def one_answer(predict: Locator) -> bool:
    """Whether one answer is drawn on the axis of a prediction."""
    return sum(int(title.split()[0]) for title in predict.locator("title").all_text_contents()) == 1


def test_a_question_leaves_the_pictures_of_the_lab_their_room(page: Page, server: str) -> None:
    page.set_viewport_size({"width": 1280, "height": 720})
    opened(page, server, "/lab.html")
    await_map(page)
    page.get_by_role("button", name="Ask", exact=True).click()
    dialog = page.get_by_role("dialog")
    dialog.get_by_label("Question").fill("Which belief has a cell that no beam has touched?")
    dialog.get_by_label("Option A").fill("0")
    dialog.get_by_label("Option B").fill("0.5")
    dialog.get_by_role("button", name="Ask").click()
    expect(page.get_by_role("button", name="Show the result")).to_be_in_viewport(ratio=1)
    left = [
        page.locator(one).evaluate("(box) => box.getBoundingClientRect().x")
        for one in (".class-card h2", ".class-bar-box .class-dot")
    ]
    assert left[0] == left[1]  # the question begins where the line below it does
    curve = page.locator(".lab-curve").bounding_box()
    assert curve is not None
    for picture in page.locator(".lab-stage .plate-picture").all():
        box = picture.bounding_box()
        assert box is not None
        assert box["height"] > 150
        assert box["y"] + box["height"] <= curve["y"]
        expect(picture).to_be_in_viewport(ratio=1)
    ended(page)
