"""The search for Firefox and WebKit: what is found, and the sentence where a program is missing."""

from __future__ import annotations

import os
import sys

import pytest

from tests.browser.engines.programs import FIREFOX, FOLDERS, WEBKIT, main
from tests.browser.test_find_chromium import program
from tests.programs import MissingProgramError


@pytest.fixture(autouse=True)
def only_path(tmp_path, monkeypatch):
    """A PATH that holds only ``tmp_path``: nothing of this machine can be found or installed."""
    monkeypatch.setenv("PATH", str(tmp_path))
    monkeypatch.delenv("CI", raising=False)


@pytest.mark.skipif(sys.platform == "darwin", reason="looks into /Applications as well")
def test_a_firefox_that_is_a_snap_is_none(tmp_path):
    program(tmp_path, "firefox-esr", 'exec /snap/bin/firefox "$@"')
    with pytest.raises(MissingProgramError, match=r"The tests in Firefox need it .*: install it"):
        FIREFOX.found()
    good = program(tmp_path, "firefox", "echo Firefox 153")
    assert FIREFOX.found() == {"Firefox": good}


def test_the_missing_programs_of_webkit_are_named(tmp_path):
    program(tmp_path, "Xvfb", "")
    with pytest.raises(MissingProgramError, match=r"WebKitWebDriver.* missing\): install them") as refused:
        WEBKIT.found()
    assert "Xvfb," not in str(refused.value)
    assert all(not folder.startswith("/") for folder in FOLDERS)


@pytest.mark.skipif(sys.platform == "darwin", reason="looks into /Applications as well")
def test_without_them_each_has_one_sentence_and_only_ci_fails(tmp_path, monkeypatch, capsys):
    assert main() == 0
    printed = capsys.readouterr()
    assert printed.out == ""
    assert len(printed.err.splitlines()) == 2
    monkeypatch.setenv("CI", "true")
    assert main() == 1


@pytest.mark.skipif(sys.platform == "darwin" or os.geteuid() != 0, reason="only root installs without sudo")
def test_it_installs_what_is_missing_and_prints_it(tmp_path, capfd):
    made = tmp_path / "firefox-esr"
    program(tmp_path, "env", 'shift; exec "$@"')
    program(
        tmp_path,
        "apt-get",
        f'if [ "$4" = firefox-esr ] || [ "$5" = firefox-esr ]; then printf x > {made}; /bin/chmod 755 {made}; fi',
    )
    main()
    assert capfd.readouterr().out.splitlines()[0] == str(made)
