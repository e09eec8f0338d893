"""Cookies that prove the token, with a clock of the test's own: how long they are valid, what outlasts a restart."""

from __future__ import annotations

import asyncio
from pathlib import Path

import pytest

from server.http.sign_ins import MAX_ENDED, VALID_S, SignIns
from tests.server.service import PATIENCE_S


class Clock:
    now = 1e9

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


def test_a_cookie_is_valid_for_a_time_and_for_one_token(tmp_path: Path, clock: Clock) -> None:
    ours = SignIns("long enough", tmp_path / "ended", clock)
    cookie = ours.cookie()
    assert ours.is_valid(cookie)
    assert not SignIns("another one", tmp_path / "ended", clock).is_valid(cookie)
    assert not SignIns(None, tmp_path / "ended", clock).is_valid(cookie)
    given, name, digest = cookie.split(".")
    later = f"{int(given, 16) + 1:x}"
    for forged in ("", "..", f"{later}.{name}.{digest}", f"{given}.{name}x.{digest}", f"{given}.{name}.", "é.b.c"):
        assert not ours.is_valid(forged)
    clock.now += VALID_S
    assert not ours.is_valid(cookie)


def test_what_ended_stays_ended_after_a_restart(tmp_path: Path, clock: Clock) -> None:
    file = tmp_path / "ended"
    before = SignIns("long enough", file, clock)
    ended, other = before.cookie(), before.cookie()
    before.end(ended)
    before.end("1.2.3")  # not one of ours
    after = SignIns("long enough", file, clock)
    assert [after.is_valid(one) for one in (ended, other)] == [False, True]
    after.end_all()
    again = SignIns("long enough", file, clock)
    assert not again.is_valid(other)
    late = again.cookie()
    assert again.is_valid(late)  # in the same second
    again.end_all()
    assert not again.is_valid(late)
    file.write_text("{")
    clock.now += 5
    assert not SignIns("long enough", file, clock).is_valid(other)


def test_the_record_is_bounded_and_forgets_nothing(
    tmp_path: Path, clock: Clock, monkeypatch: pytest.MonkeyPatch
) -> None:
    ours = SignIns("long enough", tmp_path / "ended", clock)
    monkeypatch.setattr(ours, "_write", lambda: None)  # four thousand times to the disk
    cookies = []
    for _ in range(MAX_ENDED + 2):
        clock.now += 1
        cookies.append(ours.cookie())
        ours.end(cookies[-1])
    assert not any(map(ours.is_valid, cookies))
    assert ours.is_valid(ours.cookie())


async def test_who_watches_a_cookie_learns_that_it_has_ended_also_by_another_service_or_by_its_age(
    tmp_path: Path, clock: Clock
) -> None:
    ours = SignIns("long enough", tmp_path / "ended", clock)
    cookies = [ours.cookie() for _ in range(3)]
    with ours.watching(cookies[0]) as first, ours.watching(cookies[1]) as second, ours.watching(cookies[2]) as third:
        await asyncio.to_thread(ours.end, cookies[0])
        await asyncio.wait_for(first.wait(), PATIENCE_S)
        elsewhere = SignIns("long enough", tmp_path / "ended of another service", clock)
        elsewhere.end(cookies[1])
        ours.take_over(elsewhere.ended)
        await asyncio.wait_for(second.wait(), PATIENCE_S)
        assert not third.is_set()
    clock.now += VALID_S - 0.05
    with ours.watching(cookies[2]) as old:
        assert not old.is_set()
        clock.now += 0.05
        await asyncio.wait_for(old.wait(), PATIENCE_S)
    with ours.watching(cookies[2]) as ended:
        assert ended.is_set()
