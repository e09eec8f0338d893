"""Which worker has a request: the rules of HAProxy's configuration, with CRC-32 from another place."""

from __future__ import annotations

import binascii

import pytest

from server.workers.places import worker_of, worker_of_class, worker_of_place

WORKERS = 5
ADDRESS = "192.0.2.7"


def head(target: str, *headers: str) -> bytes:
    return "\r\n".join([f"GET {target} HTTP/1.1", "Host: localhost", *headers, "", ""]).encode()


def of(target: str, *headers: str) -> int | None:
    return worker_of(head(target, *headers), ADDRESS, WORKERS)


def crc(text: str) -> int:
    return binascii.crc32(text.encode()) % WORKERS


@pytest.mark.parametrize(
    "path",
    ["/api/sessions/13.abc", "/api/sessions/13.abc/stream?x=1", "/scenes/13.abc/plain/"],
)
def test_a_session_is_where_its_id_begins_with_whoever_asks(path: str) -> None:
    assert of(path, "Cookie: gridbloom_visitor=someone") == 13 % WORKERS


def test_a_place_that_is_no_number_is_one_of_the_workers() -> None:
    assert of("/api/sessions/c0ffee.abc") == worker_of_place("c0ffee", WORKERS) == crc("c0ffee")


@pytest.mark.parametrize("typed", ["BCDFGH", "bcdfgh", "bcd-fgh", "bcd%20fgh"])
@pytest.mark.parametrize("path", ["/class/{}", "/class/{}/lab.html", "/api/classes/{}/stream"])
def test_a_class_is_where_its_code_leads_however_it_was_typed(path: str, typed: str) -> None:
    assert of(path.format(typed), "Cookie: gridbloom_visitor=me") == worker_of_class("BCDFGH", WORKERS) == crc("BCDFGH")


@pytest.mark.parametrize(
    "cookie",
    [
        "Cookie: gridbloom_visitor=abc",
        "Cookie:gridbloom_visitor=abc",
        "cookie: theme=dark; gridbloom_visitor=abc; other=1",
        "COOKIE: my_gridbloom_visitor=no; gridbloom_visitor=abc",
    ],
)
def test_all_that_a_visitor_does_without_a_session_is_in_one_worker(cookie: str) -> None:
    assert {of(path, cookie) for path in ("/", "/api/logs", "/api/sessions", "/api/classes")} == {crc("abc")}


def test_without_a_cookie_the_address_counts_and_a_proxys_place_before_both() -> None:
    assert of("/") == crc(ADDRESS)
    assert of("/", "X-Gridbloom-Place: 8", "Cookie: gridbloom_visitor=abc") == 8 % WORKERS


def test_what_all_answer_alike_and_what_is_not_http_stay_where_they_arrive() -> None:
    assert of("/assets/lab.js") is of("/livez") is worker_of(b"\x16\x03\x01\r\n\r\n", ADDRESS, WORKERS) is None


def test_a_body_does_not_count_as_headers() -> None:
    whole = head("/") + b"\r\ncookie: gridbloom_visitor=abc\r\n"
    assert worker_of(whole, ADDRESS, WORKERS) == crc(ADDRESS)
