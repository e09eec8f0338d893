"""The order of turns, with a simulated clock and jobs that compute nothing."""

from __future__ import annotations

import asyncio
import math
import threading
from collections import Counter
from concurrent.futures import ThreadPoolExecutor

import pytest

from mapper.core.parallel import cores
from server.work.scheduler import (
    DEFERRED_EVERY_S,
    HEAVY_S,
    LIGHTER,
    RECENT_S,
    URGENT_S,
    JobOwner,
    RecentComputing,
    Scheduler,
    Turn,
    checkpoint,
)
from tests.server.service import PATIENCE_S

SLICE_S = 1.0 / 16.0  #: exact in binary, so that sums of it are


class Simulated:
    """A scheduler on a clock that moves only when slices are computed."""

    def __init__(self, slots: int) -> None:
        self.now = 0.0
        self.scheduler = Scheduler(slots, SLICE_S, clock=lambda: self.now)
        self.turns: dict[str, Turn] = {}

    def request(self, name: str, visitor: str, address: str = "here", *, interactive: bool = False) -> None:
        self.turns[name] = self.scheduler.request(JobOwner(visitor, address), interactive=interactive)

    def running(self) -> list[str]:
        return [name for name, turn in self.turns.items() if turn.granted.done()]

    def slices(self, count: int, seconds: float = SLICE_S) -> list[str]:
        """Advance the job that runs longest to a checkpoint, ``count`` times; return the names of the jobs."""
        names = []
        for _ in range(count):
            name = min(self.running(), key=lambda one: self.turns[one].began)
            names.append(name)
            turn = self.turns[name]
            self.now = max(self.now, turn.began + seconds)
            if self.scheduler.should_yield(turn):
                self.scheduler.yield_turn(turn)
            else:
                turn.began = self.now  # it continues
        return names

    def release(self, name: str) -> None:
        self.scheduler.release(self.turns.pop(name))


def test_a_visitors_many_jobs_share_one_part() -> None:
    simulated = Simulated(1)
    for n in range(3):
        simulated.request(f"heavy {n}", "ann", "a")
    simulated.request("light", "bob", "b")
    order = simulated.slices(12)
    assert Counter(name.split()[0] for name in order) == {"heavy": 6, "light": 6}
    assert Counter(order) == {"heavy 0": 2, "heavy 1": 2, "heavy 2": 2, "light": 6}


def test_visitors_of_one_address_share_one_part() -> None:
    simulated = Simulated(1)
    for n in range(5):
        simulated.request(f"many {n}", f"visitor {n}", "a")
    simulated.request("one", "bob", "b")
    order = simulated.slices(20)
    assert Counter(name.split()[0] for name in order) == {"many": 10, "one": 10}


def test_within_an_address_visitors_alternate() -> None:
    simulated = Simulated(1)
    for n in range(3):
        simulated.request(f"ann {n}", "ann")
    simulated.request("bob", "bob")
    order = simulated.slices(12)
    assert Counter(name.split()[0] for name in order) == {"ann": 6, "bob": 6}


def test_two_slots_are_shared_by_two_visitors() -> None:
    simulated = Simulated(2)
    for n in range(3):
        simulated.request(f"heavy {n}", "ann", "a")
    simulated.request("light", "bob", "b")
    order = simulated.slices(40)
    assert Counter(name.split()[0] for name in order)["light"] >= 18
    assert len(simulated.running()) == 2


def test_a_turn_is_yielded_only_after_a_slice_and_only_if_a_job_waits() -> None:
    simulated = Simulated(1)
    simulated.request("first", "ann")
    turn = simulated.turns["first"]
    simulated.now = 10 * SLICE_S
    assert not simulated.scheduler.should_yield(turn)
    simulated.request("second", "bob")
    assert simulated.scheduler.should_yield(turn)
    simulated.scheduler.yield_turn(turn)
    assert simulated.running() == ["second"]
    simulated.now += 0.9 * SLICE_S
    assert not simulated.scheduler.should_yield(simulated.turns["second"])


@pytest.mark.parametrize("address", ["here", "there"])
def test_of_two_turns_of_an_owner_one_is_yielded_within_its_slice(address: str) -> None:
    """A user who has no turn does not wait for the end of a slice while another one has both."""
    simulated = Simulated(2)
    for n in range(3):
        simulated.request(f"ann {n}", "ann", interactive=True)
    short = SLICE_S / 4.0
    assert set(simulated.slices(2, short)) == {"ann 0", "ann 1"}
    assert set(simulated.running()) == {"ann 0", "ann 1"}  # the third one of the same owner waits for the slice
    simulated.request("bob", "bob", address, interactive=True)
    simulated.slices(1, short)
    assert len(running := simulated.running()) == 2
    assert "bob" in running
    simulated.slices(4, short)
    assert simulated.running() == running  # each has one: both keep it


def test_a_turn_is_not_yielded_within_its_slice_to_a_job_that_no_user_waits_for() -> None:
    simulated = Simulated(2)
    for n in range(2):
        simulated.request(f"ann {n}", "ann", interactive=True)
    simulated.request("bob", "bob", "there")
    simulated.slices(2, SLICE_S / 4.0)
    assert set(simulated.running()) == {"ann 0", "ann 1"}


def test_interactive_jobs_precede_others() -> None:
    simulated = Simulated(2)
    for n in range(3):
        simulated.request(f"story {n}", "ann", "a")
    assert simulated.running() == ["story 0", "story 1"]
    simulated.now = 0.01
    simulated.request("slider", "bob", "b", interactive=True)
    # Both yield at their next checkpoint, not only at the end of their slices.
    for name in ("story 0", "story 1"):
        assert simulated.scheduler.should_yield(simulated.turns[name])
        simulated.scheduler.yield_turn(simulated.turns[name])
    assert simulated.running() == ["slider"]
    simulated.release("slider")
    assert len(simulated.running()) == 2


def test_interactive_jobs_precede_others_of_the_same_address() -> None:
    simulated = Simulated(2)
    for n in range(3):
        simulated.request(f"story {n}", f"visitor {n}", "here")
    simulated.request("slider", "bob", "here", interactive=True)
    simulated.now = 0.01
    simulated.scheduler.yield_turn(simulated.turns["story 0"])
    assert "slider" in simulated.running()
    assert "story 0" not in simulated.running()


def test_deferred_jobs_still_get_slices() -> None:
    """Urgent jobs without a pause leave a share of the time to deferred ones."""
    simulated = Simulated(1)
    simulated.request("slider", "bob", "b", interactive=True)
    simulated.request("story", "ann", "a")
    seen = Counter[str]()
    for n in range(200):
        name = simulated.running()[0]
        turn = simulated.turns[name]
        simulated.now = turn.began + (SLICE_S if name == "story" else 0.01)
        if name == "story":
            assert simulated.scheduler.should_yield(turn)
            seen[name] += 1
            simulated.scheduler.yield_turn(turn)
        else:
            seen["slider"] += 1
            simulated.request(f"slider {n}", "bob", "b", interactive=True)
            simulated.release(name)
    computed = {"story": SLICE_S * seen["story"], "slider": 0.01 * seen["slider"]}
    assert computed["story"] / sum(computed.values()) == pytest.approx(SLICE_S / (SLICE_S + DEFERRED_EVERY_S), abs=0.05)


def test_a_long_job_is_urgent_only_at_first() -> None:
    simulated = Simulated(1)
    simulated.request("long", "ann", "a", interactive=True)
    simulated.request("story", "bob", "b")
    order = simulated.slices(60)
    first = order[: round(URGENT_S / SLICE_S)]
    assert first.count("long") >= len(first) - 2
    assert Counter(order[20:])["long"] == pytest.approx(20, abs=1)


def test_the_address_that_computed_least_of_late_may_use_more_cores() -> None:
    simulated = Simulated(3)

    def leaves(name: str) -> bool:
        return simulated.scheduler.leaves_cores(simulated.turns[name])

    simulated.request("heavy", "ann", "a", interactive=True)
    assert not leaves("heavy")  # it computes alone
    simulated.now += 10.0 * SLICE_S
    simulated.request("light", "bob", "b", interactive=True)
    assert (leaves("heavy"), leaves("light")) == (True, False)
    simulated.request("more", "cis", "b", interactive=True)
    assert (leaves("heavy"), leaves("light"), leaves("more")) == (True, True, True)
    simulated.release("more")
    for name in ("heavy", "light"):
        simulated.release(name)
    simulated.request("again", "ann", "a", interactive=True)  # a new job of the address that computed more
    simulated.request("other", "bob", "b", interactive=True)
    assert (leaves("again"), leaves("other")) == (True, False)
    simulated.release("again")
    simulated.now += 20.0 * RECENT_S  # what was computed long ago counts no more
    simulated.request("again", "ann", "a", interactive=True)
    assert (leaves("again"), leaves("other")) == (False, True)


def _computed(seconds: float) -> Simulated:
    """Return two slots that both compute urgent jobs of "ann" since ``seconds``; more jobs of hers wait."""
    simulated = Simulated(2)
    for n in range(4):
        simulated.request(f"map {n}", "ann", "a", interactive=True)
    while simulated.now < seconds:
        name = simulated.slices(1)[0]
        simulated.release(name)  # the map is made: the next one is requested
        simulated.request(name, "ann", "a", interactive=True)
    return simulated


def test_urgent_jobs_of_an_address_that_computed_much_of_late_are_deferred() -> None:
    simulated = _computed(2.0 * HEAVY_S)
    simulated.request("slider", "bob", "b", interactive=True)
    held = simulated.running()
    assert len(held) == 2
    simulated.now += SLICE_S / 4.0
    for name in held:
        assert simulated.scheduler.should_yield(simulated.turns[name])
        simulated.scheduler.yield_turn(simulated.turns[name])
    assert simulated.running() == ["slider"]  # it has the machine for itself
    assert not simulated.scheduler.leaves_cores(simulated.turns["slider"])
    simulated.now += SLICE_S / 4.0
    assert not simulated.scheduler.should_yield(simulated.turns["slider"])
    simulated.release("slider")
    assert len(simulated.running()) == 2


def test_an_address_that_computed_much_still_gets_slices() -> None:
    """Urgent jobs of others without a pause leave it slices, and a job that no user waits for too."""
    simulated = Simulated(1)
    for n in range(3):
        simulated.scheduler._recent.add("a", 2.0, 0.0)
        simulated.request(f"map {n}", "ann", "a", interactive=True)
    simulated.request("slider", "bob", "b", interactive=True)
    simulated.request("story", "cis", "c")
    seen = Counter[str]()
    for n in range(60):
        name = simulated.running()[0]
        simulated.now += SLICE_S if name[:3] in ("map", "sto") else SLICE_S / 4.0
        seen[name[:3]] += 1
        turn = simulated.turns[name]
        if name[:3] != "sli":
            assert simulated.scheduler.should_yield(turn)
            simulated.scheduler.yield_turn(turn)
            continue
        simulated.request(f"slider {n}", "bob", "b", interactive=True)
        simulated.release(name)
    assert seen["sli"] > 40
    assert seen["map"] >= 1
    assert seen["sto"] >= 1


@pytest.mark.parametrize(("seconds", "idle_s"), [(HEAVY_S / 4.0, 0.0), (2.0 * HEAVY_S, 20.0 * RECENT_S)])
def test_an_address_that_computed_little_of_late_keeps_one_of_two_turns(seconds: float, idle_s: float) -> None:
    simulated = _computed(seconds)
    for name in list(simulated.turns):
        simulated.release(name)
    simulated.now += idle_s
    for n in range(2):
        simulated.request(f"map {n}", "ann", "a", interactive=True)
    simulated.request("slider", "bob", "b", interactive=True)
    simulated.slices(1, SLICE_S / 4.0)
    running = simulated.running()
    assert "slider" in running
    assert len(running) == 2
    simulated.slices(2, SLICE_S / 4.0)
    assert simulated.running() == running


@pytest.mark.parametrize(
    ("computed", "more"),
    [({"a": HEAVY_S, "b": LIGHTER * HEAVY_S}, {"a"}), ({"a": HEAVY_S, "b": 0.9 * HEAVY_S}, set()), ({"a": 9.0}, set())],
)
def test_much_more_is_relative_and_of_late(computed: dict[str, float], more: set[str]) -> None:
    recent = RecentComputing()
    for address, seconds in computed.items():
        recent.add(address, 2.0 * seconds, 0.0)
    later = RECENT_S * math.log(2.0)  # it counts half
    assert recent.much_more(set(computed), 0.999 * later) == more
    assert recent.much_more(set(computed), later + 20.0 * RECENT_S) == set()
    assert {address: recent.of(address, later) for address in computed} == pytest.approx(computed)


async def test_a_job_has_the_cores_that_the_scheduler_leaves_it() -> None:
    scheduler = Scheduler(2)
    with ThreadPoolExecutor(2) as pool:
        alone = await scheduler.run(pool, JobOwner("ann", "a"), cores)
        entered, gate = threading.Event(), threading.Event()

        def hold() -> int:
            entered.set()
            assert gate.wait(PATIENCE_S)
            return cores()

        held = asyncio.ensure_future(scheduler.run(pool, JobOwner("ann", "a"), hold))
        await asyncio.to_thread(entered.wait, PATIENCE_S)
        assert await scheduler.run(pool, JobOwner("ann", "a"), cores) == 1
        assert await scheduler.run(pool, JobOwner("bob", "b"), cores) == alone
        gate.set()
        assert await held == alone == cores()


def test_a_released_turn_is_not_granted() -> None:
    simulated = Simulated(1)
    simulated.request("first", "ann")
    simulated.request("second", "bob")
    simulated.request("third", "cis")
    simulated.release("second")
    simulated.release("first")
    assert simulated.running() == ["third"]
    simulated.release("third")
    simulated.request("fourth", "dan")
    assert simulated.running() == ["fourth"]


async def test_jobs_on_threads_yield_at_checkpoints() -> None:
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
        held = asyncio.ensure_future(scheduler.run(pool, JobOwner("gate"), lambda: gate.wait(PATIENCE_S)))
        await asyncio.sleep(0)
        jobs = [
            asyncio.ensure_future(scheduler.run(pool, JobOwner(name), lambda name=name: job(name), interactive=False))  # type: ignore[misc]
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
        held = asyncio.ensure_future(scheduler.run(pool, JobOwner("ann"), lambda: gate.wait(PATIENCE_S)))
        await asyncio.sleep(0)
        waiting = asyncio.ensure_future(scheduler.run(pool, JobOwner("bob"), begun.set))
        await asyncio.sleep(0)
        waiting.cancel()
        await asyncio.gather(waiting, return_exceptions=True)
        gate.set()
        await held
        assert await scheduler.run(pool, JobOwner("cis"), lambda: 7) == 7
    assert not begun.is_set()


async def test_a_job_that_fails_releases_its_turn() -> None:
    def fail() -> None:
        raise ValueError("no")

    scheduler = Scheduler(1)
    with ThreadPoolExecutor(1) as pool:
        for _ in range(3):
            with pytest.raises(ValueError, match="no"):
                await scheduler.run(pool, JobOwner("ann"), fail)


def test_outside_a_job_a_checkpoint_does_nothing() -> None:
    checkpoint()
