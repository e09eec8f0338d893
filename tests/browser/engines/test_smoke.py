"""Each page in Firefox and WebKit: it shows what it is for, fits a phone, satisfies axe, and reports no error."""

from __future__ import annotations

from tests.browser.engines.tab import DESKTOP, PHONE, Tab
from tests.browser.looking import until
from tests.browser.pages.test_axe import READY


def test_every_page(tab: Tab) -> None:
    for path, shown in READY.items():
        tab.driver.resize(*DESKTOP)
        tab.open(path)
        tab.shows(shown)
        if path in ("/", "/lab.html"):
            tab.await_map()
        tab.driver.resize(*PHONE)
        tab.fits()
        # Axe takes longer for all of the lecture than everything else here: a story of the lecture has it.
        assert path == "/lecture.html" or tab.violations() == []
        assert tab.problems() == []
    problems_are_noticed(tab)


def problems_are_noticed(tab: Tab) -> None:
    """On the page that is open, which has no button without a name and no error before."""
    tab.run("""async () => {
      console.error("one", 2);
      setTimeout(() => { throw new Error("thrown"); });
      Promise.reject(new Error("rejected"));
      await fetch("/api/sessions/none");
      await fetch("https://example.org/").catch(() => null);
      new WebSocket(`ws://${location.host}/api/none`);
      document.body.append(Object.assign(new Image(), { src: "/none.png" }), document.createElement("button"));
    }""")
    expected = ["console: one 2", "thrown", "rejected", "status 404", "against the policy", "socket", "not loaded"]

    def unnoticed() -> list[str]:
        found = tab.problems()
        return [one for one in expected if not any(one in problem for problem in found)]

    until("every problem to be noticed", lambda: not unnoticed())
    assert any("button-name" in one for one in tab.violations())
    tab.run("() => sessionStorage.clear()")
