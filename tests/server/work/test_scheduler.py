"""The order of turns, with a clock of the test's own and jobs that compute nothing."""

from __future__ import annotations

import asyncio
import threading
from collections import Counter
from concurrent.futures import ThreadPoolExecutor

import pytest

from server.work.scheduler import STAND_BACK_S, URGENT_S, Party, Scheduler, Turn, checkpoint
from tests.server.service import PATIENCE_S

SLICE_S = 1.0 / 16.0  #: exact in binary, so that sums of it are


class Simulated:
    """A scheduler on a clock that moves only when slices are computed."""

    def __init__(self, slots: int) -> None:
        self.now = 0.0
        self.scheduler = Scheduler(slots, SLICE_S, clock=lambda: self.now)
        self.turns: dict[str, Turn] = {}

    def ask(self, name: str, visitor: str, address: str = "here", *, waited_for: bool = False) -> None:
        self.turns[name] = self.scheduler.ask(Party(visitor, address), waited_for=waited_for)

    def running(self) -> list[str]:
        return [name for name, turn in self.turns.items() if turn.granted.done()]

    def slices(self, count: int, seconds: float = SLICE_S) -> list[str]:
        """Let the oldest of the running jobs come to a checkpoint after so many seconds; return whose they were."""
        names = []
        for _ in range(count):
            name = min(self.running(), key=lambda one: self.turns[one].began)
            names.append(name)
            turn = self.turns[name]
            self.now = max(self.now, turn.began + seconds)
            if self.scheduler.is_over(turn):
                self.scheduler.hand_on(turn)
            else:
                turn.began = self.now  # it goes on
        return names

    def leave(self, name: str) -> None:
        self.scheduler.leave(self.turns.pop(name))


def test_a_visitors_many_jobs_share_one_part() -> None:
    simulated = Simulated(1)
    for n in range(3):
        simulated.ask(f"heavy {n}", "ann", "a")
    simulated.ask("light", "bob", "b")
    order = simulated.slices(12)
    assert Counter(name.split()[0] for name in order) == {"heavy": 6, "light": 6}
    assert Counter(order) == {"heavy 0": 2, "heavy 1": 2, "heavy 2": 2, "light": 6}


def test_a_visitor_who_drops_the_cookie_is_still_one_address() -> None:
    simulated = Simulated(1)
    for n in range(5):
        simulated.ask(f"many {n}", f"visitor {n}", "a")
    simulated.ask("one", "bob", "b")
    order = simulated.slices(20)
    assert Counter(name.split()[0] for name in order) == {"many": 10, "one": 10}


def test_within_an_address_visitors_alternate() -> None:
    simulated = Simulated(1)
    for n in range(3):
        simulated.ask(f"ann {n}", "ann")
    simulated.ask("bob", "bob")
    order = simulated.slices(12)
    assert Counter(name.split()[0] for name in order) == {"ann": 6, "bob": 6}


def test_of_two_turns_at_a_time_each_visitor_has_one() -> None:
    simulated = Simulated(2)
    for n in range(3):
        simulated.ask(f"heavy {n}", "ann", "a")
    simulated.ask("light", "bob", "b")
    order = simulated.slices(40)
    assert Counter(name.split()[0] for name in order)["light"] >= 18
    assert len(simulated.running()) == 2


def test_a_turn_is_handed_on_only_after_a_slice_and_only_where_somebody_waits() -> None:
    simulated = Simulated(1)
    simulated.ask("first", "ann")
    turn = simulated.turns["first"]
    simulated.now = 10 * SLICE_S
    assert not simulated.scheduler.is_over(turn)
    simulated.ask("second", "bob")
    assert simulated.scheduler.is_over(turn)
    simulated.scheduler.hand_on(turn)
    assert simulated.running() == ["second"]
    simulated.now += 0.9 * SLICE_S
    assert not simulated.scheduler.is_over(simulated.turns["second"])


def test_what_a_person_waits_for_comes_before_what_nobody_waits_for() -> None:
    simulated = Simulated(2)
    for n in range(3):
        simulated.ask(f"story {n}", "ann", "a")
    assert simulated.running() == ["story 0", "story 1"]
    simulated.now = 0.01
    simulated.ask("slider", "bob", "b", waited_for=True)
    # Both stand back at their next checkpoint, not only at the end of their slices.
    for name in ("story 0", "story 1"):
        assert simulated.scheduler.is_over(simulated.turns[name])
        simulated.scheduler.hand_on(simulated.turns[name])
    assert simulated.running() == ["slider"]
    simulated.leave("slider")
    assert len(simulated.running()) == 2


def test_one_address_makes_no_difference_to_that() -> None:
    simulated = Simulated(2)
    for n in range(3):
        simulated.ask(f"story {n}", f"visitor {n}", "here")
    simulated.ask("slider", "bob", "here", waited_for=True)
    simulated.now = 0.01
    simulated.scheduler.hand_on(simulated.turns["story 0"])
    assert "slider" in simulated.running()
    assert "story 0" not in simulated.running()


def test_what_stands_back_comes_to_its_end_all_the_same() -> None:
    """Short urgent jobs without a pause leave a slice to the others now and then."""
    simulated = Simulated(1)
    simulated.ask("slider", "bob", "b", waited_for=True)
    simulated.ask("story", "ann", "a")
    seen = Counter[str]()
    for n in range(200):
        name = simulated.running()[0]
        turn = simulated.turns[name]
        simulated.now = turn.began + (SLICE_S if name == "story" else 0.01)
        if name == "story":
            assert simulated.scheduler.is_over(turn)
            seen[name] += 1
            simulated.scheduler.hand_on(turn)
        else:
            seen["slider"] += 1
            simulated.ask(f"slider {n}", "bob", "b", waited_for=True)
            simulated.leave(name)
    computed = {"story": SLICE_S * seen["story"], "slider": 0.01 * seen["slider"]}
    assert computed["story"] / sum(computed.values()) == pytest.approx(SLICE_S / (SLICE_S + STAND_BACK_S), abs=0.05)


def test_a_long_job_is_urgent_only_at_first() -> None:
    simulated = Simulated(1)
    simulated.ask("long", "ann", "a", waited_for=True)
    simulated.ask("story", "bob", "b")
    order = simulated.slices(60)
    first = order[: round(URGENT_S / SLICE_S)]
    assert first.count("long") >= len(first) - 2
    assert Counter(order[20:])["long"] == pytest.approx(20, abs=1)


def test_whoever_leaves_is_given_nothing() -> None:
    simulated = Simulated(1)
    simulated.ask("first", "ann")
    simulated.ask("second", "bob")
    simulated.ask("third", "cis")
    simulated.leave("second")
    simulated.leave("first")
    assert simulated.running() == ["third"]
    simulated.leave("third")
    simulated.ask("fourth", "dan")
    assert simulated.running() == ["fourth"]


async def test_jobs_on_threads_hand_their_turns_on_at_checkpoints() -> None:
    scheduler = Scheduler(1, slice_s=0.0)
    lock, inside, order = threading.Lock(), 0, []

    def job(name: str) -> str:
        nonlocal inside
        for _ in range(5):
            with lock:
                inside += 1
                assert inside == 1
            order.append(name)
            with lock:
                inside -= 1
            checkpoint()
        return name

    with ThreadPoolExecutor(4) as pool:
        gate = threading.Event()
        held = asyncio.ensure_future(scheduler.run(pool, Party("gate"), lambda: gate.wait(PATIENCE_S)))
        await asyncio.sleep(0)
        jobs = [
            asyncio.ensure_future(scheduler.run(pool, Party(name), lambda name=name: job(name), waited_for=False))  # type: ignore[misc]
            for name in ("ann", "bob")
        ]
        await asyncio.sleep(0)
        gate.set()
        assert await asyncio.gather(*jobs) == ["ann", "bob"]
        await held
    assert order == ["ann", "bob"] * 5


async def test_a_job_that_is_cancelled_while_it_waits_never_begins() -> None:
    scheduler, begun = Scheduler(1), threading.Event()
    with ThreadPoolExecutor(2) as pool:
        gate = threading.Event()
        held = asyncio.ensure_future(scheduler.run(pool, Party("ann"), lambda: gate.wait(PATIENCE_S)))
        await asyncio.sleep(0)
        waiting = asyncio.ensure_future(scheduler.run(pool, Party("bob"), begun.set))
        await asyncio.sleep(0)
        waiting.cancel()
        await asyncio.gather(waiting, return_exceptions=True)
        gate.set()
        await held
        assert await scheduler.run(pool, Party("cis"), lambda: 7) == 7
    assert not begun.is_set()


async def test_a_job_that_fails_gives_its_turn_back() -> None:
    def fail() -> None:
        raise ValueError("no")

    scheduler = Scheduler(1)
    with ThreadPoolExecutor(1) as pool:
        for _ in range(3):
            with pytest.raises(ValueError, match="no"):
                await scheduler.run(pool, Party("ann"), fail)


def test_outside_a_job_a_checkpoint_does_nothing() -> None:
    checkpoint()
