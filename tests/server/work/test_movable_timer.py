"""A timer that is set again and again calls once, at the time that was set last."""

from __future__ import annotations

import asyncio

import pytest

from server.work.movable_timer import MovableTimer
from tests.server.service import PATIENCE_S


@pytest.mark.parametrize("first_s", [0.001, 0.02, 30.0])
async def test_it_calls_at_the_time_set_last(first_s: float) -> None:
    loop, called = asyncio.get_running_loop(), asyncio.Event()
    times: list[float] = []

    def call() -> None:
        times.append(loop.time())
        called.set()

    timer = MovableTimer(call)
    timer.set_in(first_s)
    due = loop.time() + 0.02
    timer.set(due)
    await asyncio.wait_for(called.wait(), PATIENCE_S)
    later = asyncio.Event()
    loop.call_at(due + 0.05, later.set)
    await later.wait()
    assert len(times) == 1
    # The event loop ends a timer up to the resolution of its clock too early.
    assert times[0] > due - 0.001


async def test_it_can_be_set_again_after_it_has_called_and_in_its_call() -> None:
    calls = 0
    done = asyncio.Event()

    def call() -> None:
        nonlocal calls
        calls += 1
        if calls < 3:
            timer.set_in(0.001)
        else:
            done.set()

    timer = MovableTimer(call)
    timer.set_in(0.001)
    await asyncio.wait_for(done.wait(), PATIENCE_S)
    assert calls == 3


@pytest.mark.parametrize("ends", ["set", "close"])
async def test_it_does_not_call_when_it_has_no_time_any_more(ends: str) -> None:
    calls: list[str] = []
    timer = MovableTimer(lambda: calls.append(ends))
    timer.set_in(0.005)
    timer.set(None) if ends == "set" else timer.close()
    passed = asyncio.Event()
    asyncio.get_running_loop().call_later(0.02, passed.set)
    await passed.wait()
    assert calls == []
    timer.set_in(0.001)
    other = asyncio.Event()
    asyncio.get_running_loop().call_later(0.01, other.set)
    await other.wait()
    assert calls == [ends]
