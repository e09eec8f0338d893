"""Events: what happens to a simulated robot is found at its time, with its size and its direction, and nothing else."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mapper.diagnosis import diagnose
from mapper.diagnosis.events import Event, clock_time, find_events
from mapper.sensors.scan import ScanLog
from mapper.simulation import WORLDS
from tests.bench.causes import clean
from tests.bench.disturbed_scans import BODY_M, crowded
from tests.bench.event_runs import RATE_HZ, START_NS, Happening, drive, free_scans
from tests.bench.events import BLOCKS

N = 500
WORLD, SEED = "office", 4


def at(moved: tuple[float, float, float]) -> int:
    found = free_scans(WORLD, N, SEED, moved)
    return int(found[len(found) // 2])


def the(events: list[Event]) -> Event:
    (one,) = events
    return one


@pytest.mark.parametrize("drift", [0.0, 1.0, 2.0])
def test_a_drive_in_which_nothing_happens_has_no_event(drift: float) -> None:
    assert find_events(drive(WORLD, N, seed=SEED, drift=drift)) == []


@pytest.mark.parametrize(
    ("moved", "direction", "words"),
    [
        ((0.0, 0.4, 0.0), "left", "m to its left, which the wheels did not measure."),
        ((0.0, -0.25, 0.0), "right", "m to its right, which the wheels did not measure."),
        ((-0.4, 0.0, 0.0), "behind", "m backwards, which the wheels did not measure."),
    ],
)
def test_a_push_is_found_with_its_time_size_and_side(
    moved: tuple[float, float, float], direction: str, words: str
) -> None:
    scan = at(moved)
    event = the(find_events(drive(WORLD, N, [Happening("pushed", scan, 2, moved)], seed=SEED)))
    assert (event.kind, event.direction) == ("pushed", direction)
    assert event.seconds == pytest.approx(scan / RATE_HZ, abs=1.0 / RATE_HZ)
    assert (event.ahead_m, event.left_m) == pytest.approx(moved[:2], abs=0.08)
    assert event.sentence.endswith(words)
    assert event.stamp_ns == pytest.approx(START_NS + scan / RATE_HZ * 1e9, abs=0.25e9)
    assert event.utc is not None
    assert event.utc.startswith("2025-10-09T08:5")


@pytest.mark.parametrize(("world", "seed"), [("room", 12), ("office", 14)])
def test_people_who_touch_the_sensor_push_nobody(world: str, seed: int) -> None:
    """They cover 40 % of the readings of some scans, which are aligned with them, and those after with these."""
    log = crowded(clean(world, seed), WORLDS[world], BODY_M + 0.01)
    covered = (log.ranges < 0.4).mean(axis=1)
    assert covered.max() > 0.3
    assert find_events(log) == []


def test_a_push_among_people_is_found() -> None:
    scan = at((0.0, 0.4, 0.0))
    log = drive(WORLD, N, [Happening("pushed", scan, 2, (0.0, 0.4, 0.0))], seed=SEED)

    def with_first(name: str, one: ScanLog) -> ScanLog:
        return replace(one, trajectories={name: one.trajectories[name]} | dict(one.trajectories))

    event = the(find_events(with_first("odom", crowded(with_first("true", log), WORLDS[WORLD], BODY_M + 0.01))))
    assert (event.kind, event.direction) == ("pushed", "left")
    assert event.seconds == pytest.approx(scan / RATE_HZ, abs=1.0 / RATE_HZ)
    assert event.left_m == pytest.approx(0.4, abs=0.08)


def test_a_slip_lasts_from_when_the_wheels_turn_in_vain_until_they_hold() -> None:
    event = the(find_events(drive(WORLD, N, [Happening("slipped", 200, 15, (1.2, 0.0, 0.0))], seed=SEED)))
    assert (event.kind, event.direction) == ("slipped", "behind")
    assert (event.seconds, event.until_s) == pytest.approx((200 / RATE_HZ, 215 / RATE_HZ), abs=0.41)
    assert event.distance_m == pytest.approx(1.2, abs=0.15)
    assert "the wheels measured 1." in event.sentence
    assert event.sentence.endswith("that the robot did not move: a slip.")


def test_a_robot_that_is_lifted_and_set_down_elsewhere() -> None:
    moved = (0.2, -0.6, 1.2)
    scan = at(moved)
    log = drive(WORLD, N, [Happening("lifted", scan, 12, moved)], seed=SEED)
    event = the(find_events(log))
    assert event.kind == "lifted"
    assert event.seconds == pytest.approx(scan / RATE_HZ, abs=1.01), "the first scans of a lift may fit"
    assert event.until_s == pytest.approx((scan + 12) / RATE_HZ, abs=0.41)
    assert (event.ahead_m, event.left_m, event.turned_rad) == pytest.approx(moved, abs=0.1)
    assert "lifted or carried" in event.sentence


@pytest.mark.parametrize("step", [-1.5, -30.0, 3600.0])
def test_a_clock_that_is_set(step: float) -> None:
    event = the(find_events(drive(WORLD, N, [Happening("clock", 250, 1, (step, 0.0, 0.0))], seed=SEED)))
    assert (event.kind, event.scan) == ("clock", 250)
    assert event.step_s == pytest.approx(step, abs=0.01)
    assert event.seconds == pytest.approx(50.2, abs=0.01)
    assert f"was set {'back' if step < 0.0 else 'forward'} by {abs(step):.2f} s" in event.sentence


def test_a_gap_of_a_recording_is_no_step_of_the_clock() -> None:
    log = drive(WORLD, N, seed=SEED)
    cut = log.take(np.r_[:200, 230:N])
    event = the(find_events(cut))
    assert (event.kind, event.scan, event.until_scan, event.step_s) == ("gap", 199, 200, 0.0)
    assert (event.seconds, event.until_s) == pytest.approx((199 / RATE_HZ, 230 / RATE_HZ), abs=1e-6)
    assert event.stamp_ns == log.stamps_ns[199]
    poses = log.trajectory("odom").poses
    way = np.hypot(*(poses[230] - poses[199])[:2])
    assert event.moved_m == pytest.approx(way)
    assert event.distance_m is None, "no displacement that the wheels did not measure"
    assert event.sentence == (f"At 0:39.800 nothing was recorded for 6.20 s; the robot moved {way:.2f} m meanwhile.")
    assert [one.check for one in diagnose(cut, "odom").findings if one.check.startswith("clock")] == ["clock.gap"]


def test_how_far_a_robot_came_in_a_gap_is_not_known_without_poses() -> None:
    log = drive(WORLD, N, seed=SEED)
    still = {"none": replace(log.trajectory("odom"), poses=np.zeros((N, 3)), is_placeholder=True)}
    event = the(find_events(replace(log, trajectories=still).take(np.r_[:200, 230:N])))
    assert (event.kind, event.moved_m) == ("gap", None)
    assert event.sentence.endswith("how far the robot moved meanwhile is not known.")


def test_a_step_of_the_clock_is_no_gap() -> None:
    log = drive(WORLD, N, seed=SEED)
    late = log.stamps_ns + np.where(np.arange(N) >= 200, 7_000_000_000, 0)
    assert [one.kind for one in find_events(replace(log, stamps_ns=late))] == ["clock"]


def test_people_and_a_false_mount_are_no_events() -> None:
    log = drive(WORLD, N, seed=SEED)
    random = np.random.default_rng(3)
    near = random.random(log.ranges.shape) < 0.15
    crowded = np.where(near, np.minimum(log.ranges, 8.0) * random.uniform(0.2, 0.95, near.shape), log.ranges)
    assert find_events(replace(log, ranges=crowded.astype(np.float32))) == []
    assert find_events(replace(log, mount=(0.25, 0.1, 0.05))) == []


def test_drift_after_a_push_names_it_and_remains_one_finding() -> None:
    moved = (0.0, 0.4, 0.5)
    happenings = [Happening("pushed", at(moved), 2, moved)]
    found = diagnose(drive(WORLD, N, happenings, seed=SEED, drift=0.0))
    assert [one.kind for one in found.events] == ["pushed"]
    assert [one.check for one in found.findings] == ["walls.drift"]
    assert f"what happened at {found.events[0].time}" in found.findings[0].sentence
    assert found.findings[0].scans[0] == found.events[0].scan


def test_logs_that_do_not_tell_have_no_events() -> None:
    pushed = drive(WORLD, 200, [Happening("pushed", 100, 2, (0.0, 0.3, 0.0))], seed=SEED)
    without = replace(pushed, trajectories={"true": pushed.trajectory("true")})
    assert find_events(without) == []
    assert find_events(replace(pushed, stamps_ns=np.zeros(200, dtype=np.int64))) == []
    assert find_events(pushed.take(slice(0, 20))) == []


@pytest.mark.parametrize(
    ("seconds", "text"),
    [(73.36, "1:13.360"), (59.9996, "1:00.000"), (0.0, "0:00.000"), (3671.5, "61:11.500")],
)
def test_times_are_minutes_and_seconds(seconds: float, text: str) -> None:
    assert clock_time(seconds) == text


def test_the_bench_has_cases_of_each_kind() -> None:
    assert {block.kind for block in BLOCKS} == {"pushed", "slipped", "lifted", "clock", ""}
