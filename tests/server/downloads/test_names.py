"""Names of downloaded files: valid on all systems, and equal in header and yaml."""

from __future__ import annotations

import re
from email.message import Message
from urllib.parse import unquote

import pytest
from hypothesis import given
from hypothesis import strategies as st

from server.downloads import SNAPSHOT_NAME, file_name, file_stem
from server.downloads.names import disposition

#: Names that Windows gives to devices, with any ending (Microsoft, "Naming Files, Paths, and Namespaces").
DEVICES = re.compile(r"(con|prn|aux|nul|(com|lpt)[0-9¹²³])(\..*)?", re.IGNORECASE)


@pytest.mark.parametrize(
    ("title", "stem"),
    [
        ("intel.log.gz", "intel"),
        ("fr079.v2.CLF", "fr079.v2"),
        ("run.mcap", "run"),
        ("Büro 3. Stock (neu).csv", "Büro_3._Stock_neu"),
        ("地図.bag", "地図"),
        ("../../etc/passwd", "etc_passwd"),
        ('a"b\r\nSet-Cookie: x.log', "a_b_Set-Cookie_x"),
        ("con.log", "con_"),
        ("LPT².log", "LPT²_"),
        (".log", "map"),
        ("…", "map"),
        ("office", "office"),
    ],
)
def test_files_are_named_after_their_log(title: str, stem: str) -> None:
    assert file_stem(title) == stem


@given(st.text(max_size=200))
def test_any_name_is_safe_and_read_back_from_the_header(title: str) -> None:
    name = file_name(file_stem(title), "pgm")
    assert re.fullmatch(r"[\w+-][\w.+-]*\.pgm", name)
    assert len(name.encode()) <= 255
    assert not DEVICES.fullmatch(name)
    header = disposition(name)
    assert header.isascii()
    assert header.isprintable()
    plain = re.fullmatch(r'attachment; filename="([A-Za-z0-9._+-]+\.pgm)"(?:; filename\*=UTF-8\'\'([^;]+))?', header)
    assert plain
    assert (unquote(plain[2]) if plain[2] else plain[1]) == name
    message = Message()
    message["Content-Disposition"] = header
    assert message.get_content_disposition() == "attachment"


def test_an_instant_is_part_of_the_name() -> None:
    assert file_name("intel", "pgm", "2026-01-02_03-04-05") == "intel_2026-01-02_03-04-05.pgm"
    assert re.match(SNAPSHOT_NAME, "2026-01-02_03-04-05")
    for bad in ("", "../x", "a/b", "a b", "é", "x" * 41, ".x"):
        assert not re.match(SNAPSHOT_NAME, bad)


def test_a_file_never_has_the_name_of_the_log_itself() -> None:
    assert file_name(file_stem("run.mcap"), "mcap", title="run.mcap") == "run_gridbloom.mcap"
    assert file_name(file_stem("run.bag"), "mcap", title="run.bag") == "run.mcap"
