"""The slides of a class in Chromium: what followers receive of a deck, the room above the line, slides on phones."""

from __future__ import annotations

import base64
import json
import re
import zlib
from collections.abc import Iterator

import pytest
from playwright.sync_api import BrowserContext, Error, FilePayload, Page, Request, WebSocket, WebSocketRoute, expect

from tests.browser.classes.test_class import ended
from tests.browser.conftest import standing_world
from tests.browser.lecturing import never_idle
from tests.browser.looking import await_map, drag_along, map_digest, until
from tests.browser.slides import cut_off, settle, slide_ids
from tests.marks import also_long

#: Of the lecture's own slide *One cell*.
ANSWER, NOTES = "Log-odds add up, in any order", "Let the audience count"
MARKS = ("NOTE-OF-MINE", "HIDDEN-SLIDE", "LATER-SLIDE", "LATER-PARAGRAPH", "PAST-SLIDE")


def deck_with(session: str) -> dict[str, object]:
    """Return a deck of which only the slide *Now* may be received; ``session`` is that of a lab in it."""
    slides = [
        {"kind": "text", "title": "Before", "text": "PAST-SLIDE"},
        {
            "kind": "text",
            "title": "Now",
            "text": "Shown first\n\nShown second\n\nLATER-PARAGRAPH",
            "notes": "NOTE-OF-MINE",
        },
        {"kind": "section", "section": "cell", "notes": "NOTE-OF-MINE"},
        {"kind": "text", "title": "HIDDEN-SLIDE", "text": "HIDDEN-SLIDE", "hidden": True},
        {"kind": "lab", "title": "The lab", "address": f"/lab.html?session={session}"},
        {"kind": "text", "title": "LATER-SLIDE", "text": "LATER-SLIDE"},
    ]
    return {"gridbloom_deck": 1, "title": "NOTE-OF-MINE in the title", "slides": slides}


def opened_on_slides(page: Page, server: str, path: str) -> str:
    """Open a class on slides; return its code."""
    page.goto(f"{server}{path}")
    page.get_by_role("button", name=re.compile("^Open a class")).click()
    code = page.locator(".class-code-small").text_content() or ""
    page.get_by_role("dialog").get_by_role("button", name="Close").click()
    return code


def letters_of(deck: object) -> str:
    """Return a deck as a lecturer's link has it: JSON, DEFLATE, base64 for addresses."""
    packing = zlib.compressobj(wbits=-15)
    packed = packing.compress(json.dumps(deck).encode()) + packing.flush()
    return base64.urlsafe_b64encode(packed).decode().rstrip("=")


def unpacked(text: str) -> Iterator[str]:
    """Yield a text, and what every part of it holds that is packed as decks and worlds are in addresses."""
    yield text
    for part in re.findall(r"[A-Za-z0-9_+/-]{24,}", text):
        letters = part.replace("+", "-").replace("/", "_")[: len(part) - (len(part) % 4 == 1)]
        data = base64.urlsafe_b64decode(letters + "=" * (-len(letters) % 4))
        yield data.decode("latin-1")
        for wbits in (-15, 15, 31):
            try:
                yield zlib.decompressobj(wbits).decompress(data, 1 << 22).decode("latin-1")
            except zlib.error:
                continue


class Received:
    """Everything that a page receives: the addresses it is led to, answers over HTTP, messages of its sockets."""

    def __init__(self, page: Page) -> None:
        self._page = page
        self.texts: list[str] = []
        self._requests: list[Request] = []
        page.on("framenavigated", lambda frame: self.texts.append(frame.url))
        page.on("websocket", self._watch)
        page.on("requestfinished", lambda request: self._requests.append(request))  # noqa: PLW0108 - no builtin

    def read(self) -> None:
        """Read the answers so far; the browser forgets them when the page is loaded again."""
        while self._requests:
            answer = self._requests.pop().response()
            assert answer
            self.texts.extend((answer.url, *(f"{name}: {value}" for name, value in answer.headers.items())))
            if answer.ok:
                try:
                    body = answer.body()
                except Error:  # of a file that the browser has kept it tells nothing: it is asked for again
                    body = self._page.context.request.get(answer.url).body()
                self.texts.append(body.decode("latin-1"))

    def _watch(self, socket: WebSocket) -> None:
        self.texts.append(socket.url)
        socket.on("framereceived", self._hear)

    def _hear(self, data: str | bytes) -> None:
        self.texts.append(data if isinstance(data, str) else data.decode("latin-1"))

    def found(self, secrets: tuple[str, ...]) -> set[str]:
        """Return those of the secrets that were received in any form."""
        self.read()
        return {secret for text in self.texts for one in unpacked(text) for secret in secrets if secret in one}


@pytest.mark.parametrize("from_file", [True, *also_long(False)], ids=["file", "link"])
def test_followers_receive_the_present_slide_and_nothing_else_of_the_deck(
    page: Page, context: BrowserContext, visitor: BrowserContext, server: str, *, from_file: bool
) -> None:
    never_idle(page)
    never_idle(visitor)
    session = standing_world(context, server)
    written, secrets = deck_with(session), (*MARKS, session, ANSWER, NOTES)
    deck = letters_of(written)
    assert MARKS[0] in [*unpacked(f"#&deck={deck}")][2]  # what is looked for would be found
    link = f"/lecture.html?present#own-text-2/2&deck={deck}"
    if from_file:
        code = opened_on_slides(page, server, "/lecture.html?present")
        page.get_by_role("button", name="Arrange the slides").click()
        file: FilePayload = {
            "name": "deck.json",
            "mimeType": "application/json",
            "buffer": json.dumps(written).encode(),
        }
        page.get_by_label("File of a deck").set_input_files(file)
        expect(page.get_by_text("“deck.json” is loaded.")).to_be_visible()
        page.get_by_role("button", name="Close").click()
        page.keyboard.press("PageDown")
        page.keyboard.press("PageDown")
    else:
        code = opened_on_slides(page, server, link)
    phone = visitor.new_page()
    received = Received(phone)
    phone.goto(f"{server}/class/{code}")
    now = phone.get_by_role("region", name="Now")
    expect(now).to_contain_text("Shown second")
    expect(page.get_by_role("region", name="Now")).to_contain_text("LATER-PARAGRAPH")  # the lecturer's deck works
    expect(now).not_to_contain_text("LATER")
    # nor does the lecturer's address, which the class can see on the screen
    assert not [secret for one in unpacked(page.url) for secret in secrets if secret in one]
    received.read()
    page.reload()
    expect(page.get_by_role("region", name="Now")).to_contain_text("LATER-PARAGRAPH")
    phone.reload()
    expect(now).to_contain_text("Shown second")
    page.keyboard.press("Shift+ArrowRight")
    expect(phone.get_by_role("heading", name="One cell").first).to_be_visible()
    received.read()
    page.keyboard.press("Shift+ArrowRight")
    # the lab in the slide is followed as the page of the lab is, without the id of its session
    await_map(phone)
    lab = next(frame for frame in page.frames if "/lab.html" in frame.url)
    until("the lecturer's map", lambda: map_digest(phone) == map_digest(lab))
    expect(phone.locator(".lab-title")).to_have_text("The lab")
    assert phone.url == f"{server}/class/{code}/lab.html"
    expect(phone.get_by_role("complementary", name="Class")).to_contain_text("Following the lecturer.")
    expect(phone.get_by_role("button", name="Ask for the robot")).to_be_visible()
    page.keyboard.press("b")
    expect(phone.locator(".blank-screen")).to_be_visible()
    page.keyboard.press("b")
    await_map(phone)
    assert received.found(secrets) == set()
    page.keyboard.press("Shift+ArrowRight")
    expect(phone.get_by_role("region", name="LATER-SLIDE")).to_be_visible()
    assert received.found(secrets) == {"LATER-SLIDE"}  # what is received is found
    page.keyboard.press("Shift+ArrowLeft")
    page.keyboard.press("Shift+ArrowLeft")
    for _ in ("predict", "figure", "answer"):
        page.keyboard.press("ArrowRight")
    expect(phone.get_by_text(ANSWER)).to_be_visible()
    assert received.found(secrets) == {"LATER-SLIDE", ANSWER}
    ended(page)


def test_voting_closes_with_the_figure_and_the_speaker_alone_sees_counts_and_the_right_answer(
    page: Page, visitor: BrowserContext, server: str
) -> None:
    never_idle(page)
    never_idle(visitor)
    code = opened_on_slides(page, server, "/lecture.html?present#cell/2")
    with page.expect_popup() as opening:
        page.get_by_role("button", name=re.compile("^Speaker")).click()
    speaker = opening.value
    question = speaker.get_by_role("region", name="Question")
    expect(question.get_by_role("listitem")).to_have_count(3)
    expect(question.locator(".is-right")).to_contain_text("✓ right")
    expect(page.locator(".slide-question")).not_to_contain_text("right")
    phone = visitor.new_page()
    phone.goto(f"{server}/class/{code}")
    expect(phone.get_by_text("Wait for the question.")).to_be_visible()

    question.get_by_role("button", name="Ask the class").click()
    phone.get_by_role("button", name=re.compile("^B")).click()
    expect(question.get_by_role("status")).to_have_text("1 of 1 answered, voting is open")
    expect(question.get_by_role("listitem").nth(1)).to_contain_text("1")
    expect(page.locator(".slide-option-bar")).to_have_count(0)

    speaker.get_by_role("button", name="Next", exact=True).click()  # the figure
    expect(phone.get_by_text(re.compile("^Voting is closed. You chose B: "))).to_be_visible()
    expect(phone.locator(".class-option, .slide-option")).to_have_count(0)
    expect(question.get_by_role("status")).to_have_text("1 of 1 answered, voting is closed")
    expect(phone.locator("main, .class-card").get_by_text("✓ right")).to_have_count(0)

    # that step was not meant: voting is opened again, also with the figure on the screen, and keeps the answers
    question.get_by_role("button", name="Open voting again").click()
    expect(question.get_by_role("status")).to_have_text("1 of 1 answered, voting is open")
    speaker.get_by_role("button", name="Back", exact=True).click()
    expect(phone.get_by_role("button", name=re.compile("^B"))).to_have_attribute("aria-pressed", "true")
    expect(question.get_by_role("status")).to_have_text("1 of 1 answered, voting is open")
    speaker.get_by_role("button", name="Next", exact=True).click()
    expect(question.get_by_role("status")).to_have_text("1 of 1 answered, voting is closed")
    question.get_by_role("button", name="Show the result").click()
    expect(question.get_by_role("status")).to_have_text("1 of 1 answered, the result is shown")
    expect(phone.get_by_text("✓ right")).to_be_visible()
    expect(phone.get_by_text("B is wrong; the answer is")).to_be_visible()


def test_an_answer_that_comes_too_late_is_refused_and_the_counted_one_shown(
    page: Page, visitor: BrowserContext, server: str
) -> None:
    never_idle(page)
    never_idle(visitor)
    code = opened_on_slides(page, server, "/lecture.html?present#cell/2")
    page.get_by_role("button", name="Ask the class").click()
    phone = visitor.new_page()
    states: list[str] = []

    def late(route: WebSocketRoute) -> None:
        """Deliver to the phone all messages but that voting is closed."""
        server_side = route.connect_to_server()

        def deliver(message: str | bytes) -> None:
            if '"is_closed":true' in str(message) and not states:
                states.append(str(message))
            else:
                route.send(message)

        server_side.on_message(deliver)

    phone.route_web_socket(re.compile(r"/api/classes/\w+/stream"), late)
    phone.goto(f"{server}/class/{code}")
    options = phone.locator(".slide-options")
    options.get_by_role("button", name=re.compile("^B")).click()
    expect(page.get_by_text("1 of 1 answered")).to_be_visible()
    page.get_by_role("button", name="Close voting").click()
    expect(page.get_by_text("1 of 1 answered · voting is closed")).to_be_visible()
    options.get_by_role("button", name=re.compile("^A")).click()
    expect(phone.get_by_text("Voting is closed: your answer came too late.")).to_be_visible()
    expect(options.get_by_role("button", name=re.compile("^B"))).to_have_attribute("aria-pressed", "true")
    expect(options.get_by_role("button", name=re.compile("^A"))).to_have_attribute("aria-pressed", "false")


def test_the_short_deck_is_chosen_with_its_minutes_and_a_part_keeps_its_title(page: Page, server: str) -> None:
    never_idle(page)
    page.goto(f"{server}/lecture.html?present")
    page.get_by_role("button", name="Arrange the slides").click()
    page.get_by_role("button", name="45 minutes").click()
    expect(page.get_by_text(re.compile(r"^18 of \d+ slides are shown"))).to_be_visible()
    page.get_by_role("button", name="Close", exact=True).click()
    with page.expect_popup() as opening:
        page.get_by_role("button", name=re.compile("^Speaker")).click()
    speaker = opening.value
    expect(speaker.locator(".speaker-plan")).to_contain_text("this slide until 1 of 45 min")
    page.keyboard.press("Shift+PageDown")
    expect(speaker.locator(".speaker-plan")).to_contain_text("this slide until 3 of 45 min")
    page.keyboard.press("End")
    expect(speaker.locator(".speaker-plan")).to_contain_text("this slide until 45 of 45 min")
    page.get_by_role("button", name="Arrange the slides").click()
    page.get_by_role("button", name="Part 2 only").click()
    page.get_by_role("button", name="Close", exact=True).click()
    page.keyboard.press("Home")
    expect(page.get_by_role("heading", level=1)).to_have_text("Occupancy grid mapping: When it goes wrong")


@pytest.mark.parametrize("every", [9, *also_long(1)])
def test_a_slide_is_scaled_to_the_room_above_the_line_of_the_class(page: Page, server: str, every: int) -> None:
    never_idle(page)
    page.set_viewport_size({"width": 1920, "height": 1080})
    names = slide_ids(page, server)
    opened_on_slides(page, server, "/lecture.html?present#cell/2")
    page.get_by_role("button", name="Ask the class").click()
    line = page.get_by_role("complementary", name="Class")
    problems = {}
    for name in names[::every]:  # with the question of another slide open, and of its own
        page.evaluate("place => { location.hash = place; }", f"#{name}/99")
        expect(page.locator(".on-slide, .own-slide").first).to_be_visible()
        settle(page)
        cut = cut_off(page)
        slide, below = page.locator("main").bounding_box(), line.bounding_box()
        assert slide
        assert below
        if cut or slide["y"] + slide["height"] > below["y"] + 1:
            problems[name] = (cut, slide, below)
    assert problems == {}
    page.evaluate("() => { location.hash = '#rays/3'; }")
    settle(page)
    dot = page.get_by_role("slider", name="Last cell of the line").locator("circle").last
    before = dot.bounding_box()
    assert before
    x, y = before["x"] + before["width"] / 2, before["y"] + before["height"] / 2
    drag_along(page, (x, y), (x - 100, y + 40), steps=4)
    after = dot.bounding_box()
    assert after
    cell = page.locator("#rays .stage").evaluate("e => e.getBoundingClientRect().width") / 26
    assert after["x"] - before["x"] == pytest.approx(-100, abs=cell)
    ended(page)


#: Overlapping labels of drawings, and words in a column that is narrower than most of them.
_CRAMPED = """() => {
  const found = [];
  const shown = [...document.querySelectorAll(".on-slide .lesson-room")][0];
  const isLabel = (one) => one.checkVisibility() && one.textContent.trim();
  const labels = [...shown.querySelectorAll("svg text")].filter(isLabel);
  const boxes = labels.map((one) => [one.textContent, one.getBoundingClientRect()]);
  boxes.forEach(([text, a], i) => {
    for (const [other, b] of boxes.slice(i + 1)) {
      const wide = Math.min(a.right, b.right) - Math.max(a.left, b.left);
      const high = Math.min(a.bottom, b.bottom) - Math.max(a.top, b.top);
      if (wide > 2 && high > 0.45 * Math.min(a.height, b.height)) found.push(`${text} / ${other}`);
    }
  });
  for (const one of shown.querySelectorAll(".world-stage-ladder text")) {
    const [label, drawing] = [one, one.ownerSVGElement].map((it) => it.getBoundingClientRect());
    if (label.left < drawing.left || label.right > drawing.right + 1) found.push(`cut: ${one.textContent}`);
  }
  const paper = document.createElement("canvas").getContext("2d");
  for (const one of shown.querySelectorAll("p, td, .layer-text, .field-hint")) {
    const words = [...one.childNodes].filter((n) => n.nodeType === 3).map((n) => n.data).join(" ").split(/\\s+/);
    paper.font = getComputedStyle(one).font;
    const narrow = words.filter((word) => paper.measureText(word).width > one.clientWidth + 2);
    if (one.clientWidth > 1 && words.length > 6 && (narrow.length > 0 || one.clientHeight > 4 * one.clientWidth))
      found.push(one.textContent.slice(0, 60));
  }
  const room = shown.getBoundingClientRect();
  for (const one of shown.querySelectorAll("table, .choice, .stage, .plot, .field"))
    if (one.checkVisibility() && one.getBoundingClientRect().right > room.right + 1) found.push(one.className);
  return found;
}"""
#: Whether the page, or the box of a derivation in it, scrolls sideways.
_WIDE = """() => [document.documentElement, ...document.querySelectorAll(".shows-derivation > .prose:has(.derivation)")]
  .some(one => one.scrollWidth > one.clientWidth + 1)"""
NARROW = ("model", "grid", "window", "layers", "sensor-models", "cell-derivation")


@pytest.mark.parametrize("context", ["phone"], indirect=True)
@pytest.mark.parametrize("chosen", [NARROW, *also_long(None)], ids=["the narrowest", "all"])
def test_slides_on_a_phone_are_legible(page: Page, server: str, chosen: tuple[str, ...] | None) -> None:
    never_idle(page)
    names = slide_ids(page, server)
    problems = {}
    for name in chosen or [name for name in names if not name.startswith("own-")]:
        page.evaluate("place => { location.hash = place; }", f"#{name}/99")
        expect(page.locator(f"#{name.removesuffix('-derivation')}.on-slide")).to_be_visible()
        settle(page)
        wide = page.evaluate(_WIDE)
        cramped = page.evaluate(_CRAMPED)
        if wide or cramped:
            problems[name] = (wide, cramped)
    assert problems == {}
