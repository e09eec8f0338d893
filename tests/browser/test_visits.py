"""A page that a browser test gets from an earlier one is that of a new visitor."""

from __future__ import annotations

from playwright.sync_api import Browser

from tests.browser.visits import Visit

#: What a page knows of its visitor, who begins with nothing.
STATE = """async () => ({
  cookies: document.cookie, kept: [localStorage.length, sessionStorage.length],
  databases: (await indexedDB.databases()).length,
  motion: matchMedia("(prefers-reduced-motion: reduce)").matches,
  dark: matchMedia("(prefers-color-scheme: dark)").matches,
  print: matchMedia("print").matches, width: innerWidth, name: window.name,
})"""
#: How a test may leave it.
CHANGE = """() => {
  document.cookie = "a=b";
  localStorage.setItem("a", "b");
  sessionStorage.setItem("a", "b");
  window.name = "a";
}"""


def test_the_next_test_has_a_new_visitors_page(browser: Browser, server: str) -> None:
    visit = Visit(browser, server, "laptop", "reduce")
    page = visit.watched().page
    page.goto(f"{server}/missing.html")
    state = page.evaluate(STATE)
    assert state["motion"]
    begun = page.request.post(f"{server}/api/sessions", data={"kind": "simulation"}).json()["id"]
    page.evaluate(CHANGE)
    page.emulate_media(media="print", color_scheme="dark", reduced_motion="no-preference")
    page.set_viewport_size({"width": 400, "height": 400})
    page.route("**/missing.html", lambda route: route.abort())
    visit.context.new_page()
    assert page.evaluate(STATE) != state

    assert visit.begin_again()
    assert visit.context.pages == [page]
    assert visit.context.cookies() == []
    assert page.request.get(f"{server}/api/sessions/{begun}").status == 404
    page.goto(f"{server}/missing.html")
    assert page.evaluate(STATE) == state

    page.add_init_script("window.a = 1")  # which cannot be removed
    assert not visit.begin_again()
    visit.end()
    assert page.is_closed()
