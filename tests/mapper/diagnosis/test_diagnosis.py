"""The log doctor: no findings on clean logs, and each injected fault is found at its scans."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from mapper.core.errors import ConfigError
from mapper.core.se2 import compose, inverse
from mapper.diagnosis import Finding, clock, diagnose, drift_finding, examine, readings, sweep
from mapper.diagnosis.consistency import examined
from mapper.diagnosis.drifting import first_cause
from mapper.diagnosis.finding import POSSIBLE
from mapper.diagnosis.walls import LEAST_SURE, drift_confidence
from mapper.io.logs import open_log
from mapper.mapping.parameters import MappingConfig
from mapper.puzzles.drives import TRUE, swept
from mapper.sensors.motion import Motion, seconds
from mapper.sensors.scan import ScanLog, Trajectory
from mapper.simulation import WORLDS, SensorConfig, Simulation, World, sample_log
from mapper.simulation.odometry import drifting_odometry
from tests.bench.disturbed_scans import crowded, polished
from tests.bench.doctor import part as part_of
from tests.bench.doctor import refurnished
from tests.mapper.diagnosis.runs import true_run
from tests.marks import also_long

N = 300


@pytest.fixture(scope="module")
def clean() -> ScanLog:
    return true_run(N, every=3)


def named(findings: list[Finding]) -> set[str]:
    return {finding.check for finding in findings}


def the(findings: list[Finding], check: str) -> Finding:
    (found,) = [finding for finding in findings if finding.check == check]
    assert 0.0 < found.sure <= 1.0
    return found


def of_clock(log: ScanLog) -> list[Finding]:
    """Findings of the check of the stamps; that :func:`examine` makes it is tested with a clock that jumps back."""
    return clock.check(log, examined(log, None))


def with_poses(log: ScanLog, poses: np.ndarray) -> ScanLog:
    return replace(log, trajectories={"bad": Trajectory(poses)})


@pytest.mark.parametrize("world", ["office", *also_long(*sorted(set(WORLDS) - {"office"}))])
def test_nothing_is_found_in_a_clean_log(world: str) -> None:
    log = sample_log(N, world)
    assert examine(log, "true") == []


@pytest.mark.parametrize("disturbed", [polished, crowded])
def test_polished_walls_and_people_who_walk_about_are_no_finding_and_no_event(
    disturbed: Callable[[ScanLog, World], ScanLog],
) -> None:
    log = sample_log(N, "hall", 11)
    seen = disturbed(
        replace(log, trajectories={"odom": replace(log.trajectory("true"), frame_id="odom")}), WORLDS["hall"]
    )
    assert (seen.ranges != log.ranges).mean() > 0.05
    found = diagnose(seen)
    assert (found.findings, found.events) == ((), ())


@pytest.mark.parametrize("name", ["intel", *also_long("aces", "fhw")])
def test_corrected_poses_of_real_logs_are_not_blamed(data_file: Callable[..., object], name: str) -> None:
    log = open_log(str(data_file(f"carmen/{name}-corrected.log.gz")))
    found = named(examine(log, "scan"))
    assert {name for name in found if not name.startswith("clock.")} <= {"readings.max_range"}


@pytest.mark.long  # as of Intel's odometry in test_verdict.py
def test_raw_odometry_of_a_real_log_is_blamed(data_file: Callable[..., object]) -> None:
    log = open_log(str(data_file("carmen/aces-corrected.log.gz")))
    assert "walls.drift" in named(examine(log, "wheel"))


@pytest.mark.parametrize("name", ["intel", "aces", "fhw"])
def test_no_drift_is_found_in_half_of_a_corrected_log(data_file: Callable[..., object], name: str) -> None:
    log = open_log(str(data_file(f"carmen/{name}-corrected.log.gz")))
    middle = log.n_scans // 2
    for start, stop in ((0, middle), (middle, log.n_scans)):
        assert drift_finding(part_of(log, "scan", start, stop), "scan", MappingConfig()) is None


@pytest.mark.parametrize("name", ["carmen/intel.log.gz", "carmen/loop5.log.gz", "breezyslam/exp1.dat.gz"])
def test_drift_of_a_raw_log_is_a_fact(data_file: Callable[..., object], name: str) -> None:
    finding = drift_finding(open_log(str(data_file(name))), None, MappingConfig())
    assert finding is not None
    assert finding.sure > 0.9
    assert finding.sentence.startswith("The poses drift: ")


@pytest.mark.parametrize(("shift", "is_drift"), [(0.0, False), (0.05, False), (0.5, True), (1.5, True)])
def test_a_second_half_that_is_shifted_draws_walls_double(clean: ScanLog, shift: float, is_drift: bool) -> None:
    poses = clean.trajectory().poses.copy()
    poses[N // 2 :, :2] += shift
    assert (drift_finding(with_poses(clean, poses), "bad", MappingConfig()) is not None) == is_drift


def test_people_before_the_sensor_are_no_drift(clean: ScanLog) -> None:
    rng = np.random.default_rng(2)
    people = rng.random(clean.ranges.shape) < 0.15
    ranges = np.where(people, np.minimum(clean.ranges, 8.0) * rng.uniform(0.2, 0.9, people.shape), clean.ranges)
    crowded = replace(clean, ranges=ranges.astype(np.float32))
    assert drift_finding(crowded, None, MappingConfig()) is None


def test_drift_is_judged_with_the_mount_of_the_map(clean: ScanLog) -> None:
    drifting = with_poses(clean, drifting_odometry(clean.trajectory().poses, np.random.default_rng(3)))
    as_it_is = drift_finding(drifting, None, MappingConfig())
    assert as_it_is is not None
    turned = replace(drifting, mount=(0.0, 0.0, -1.0))
    corrected = drift_finding(turned, None, MappingConfig(mount_yaw=1.0))
    assert corrected is not None
    assert corrected.sentence == as_it_is.sentence
    assert drift_finding(drifting, None, MappingConfig(range_max=0.5)) is None, "too few readings are left"


def test_furniture_that_moves_in_a_small_room_is_possible_drift_at_most() -> None:
    case = refurnished(WORLDS["room"], 3)
    finding = drift_finding(case.log, case.trajectory, MappingConfig())
    assert finding is None or (finding.possible and finding.sentence.startswith("The poses may drift: "))
    assert drift_confidence(0.0) < LEAST_SURE < POSSIBLE < drift_confidence(0.23)


def test_a_log_too_short_to_judge_has_no_drift_finding(clean: ScanLog) -> None:
    assert drift_finding(part_of(clean, "true", 0, 5), None, MappingConfig()) is None
    with pytest.raises(ConfigError, match="no trajectory"):
        drift_finding(clean, "slam", MappingConfig())


def test_of_few_readings_only_that_is_said(clean: ScanLog) -> None:
    """A single sonar's: whether poses are out of step with it, or its mount is, would be a guess."""
    late = compose(clean.trajectory().poses, np.array([0.3, 0.0, 0.2]))
    one = replace(with_poses(clean, late), ranges=clean.ranges[:, :1].copy())
    found = examine(one)
    assert [finding.check for finding in found] == ["readings.few"]
    assert f"{np.isfinite(one.ranges).sum()} readings are measured ranges, and 1000 are needed" in found[0].sentence
    assert "readings.few" not in named(examine(replace(one, ranges=clean.ranges[:, ::6].copy())))


def test_a_clock_that_jumps_back(clean: ScanLog) -> None:
    stamps = clean.stamps_ns.copy()
    stamps[120:] -= 3_000_000_000
    found = the(examine(replace(clean, stamps_ns=stamps)), "clock.backwards")
    assert found.scans == (120,)
    assert "2.60 s" in found.sentence


def test_doubled_stamps(clean: ScanLog) -> None:
    stamps = clean.stamps_ns.copy()
    stamps[[50, 90]] = stamps[[49, 89]]
    assert the(of_clock(replace(clean, stamps_ns=stamps)), "clock.doubled").scans == (50, 90)


def test_a_gap(clean: ScanLog) -> None:
    """Of a robot that drove on; one that stood meanwhile has missed nothing."""
    found = the(of_clock(clean.take(np.r_[:200, 220:N])), "clock.gap")
    assert found.scans == (200,)
    assert "8.4 s" in found.sentence
    stamps = clean.stamps_ns.copy()
    stamps[200:] += 7_000_000_000
    assert of_clock(replace(clean, stamps_ns=stamps)) == []


def by_distance(log: ScanLog, speeds: np.ndarray) -> ScanLog:
    """A log of the same scans, each recorded after the same way, at these speeds, with stops of half a minute."""
    steps = 0.2 / speeds
    steps[::40] += 30.0
    return replace(log, stamps_ns=(1e9 * np.concatenate([[0.0], np.cumsum(steps)])).astype(np.int64))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_pauses_of_a_log_that_is_recorded_by_distance_are_no_gaps(clean: ScanLog, seed: int) -> None:
    """Mostly the robot drives at one speed, and at half of it where it turns: nothing is missing."""
    random = np.random.default_rng(seed)
    slow = np.repeat(random.random(30) < 0.2, 10)[: N - 1]
    speeds = np.where(slow, 0.25, 0.5) * random.normal(1.0, 0.03, N - 1)
    assert of_clock(by_distance(clean, speeds)) == []
    varied = 0.4 * np.exp(np.convolve(random.normal(0.0, 0.5, N + 18), np.ones(20) / 4.5, mode="valid"))[: N - 1]
    assert of_clock(by_distance(clean, varied)) == []


def test_dropped_scans(clean: ScanLog) -> None:
    kept = np.setdiff1d(np.arange(N), [40, 41, 80, 120, 160, 200])
    log = replace(
        clean,
        ranges=clean.ranges[kept],
        stamps_ns=clean.stamps_ns[kept],
        trajectories={"true": Trajectory(clean.trajectory().poses[kept])},
    )
    found = the(of_clock(log), "clock.dropped")
    assert "About 6 scans" in found.sentence
    assert found.scans == (40, 78, 117, 156, 195)


def test_jitter(clean: ScanLog) -> None:
    rng = np.random.default_rng(1)
    steps = rng.exponential(0.4, N)
    found = of_clock(replace(clean, stamps_ns=(np.cumsum(steps) * 1e9).astype(np.int64)))
    assert "clock.jitter" in named(found)


def test_a_no_return_that_is_written_as_a_range(clean: ScanLog) -> None:
    ranges = np.where(np.isinf(clean.ranges), np.float32(8.0), clean.ranges)
    found = the(examine(replace(clean, ranges=ranges)), "readings.max_range")
    share = 100 * np.isinf(clean.ranges).sum() / np.isfinite(ranges).sum()
    assert f"{share:.1f} %" in found.sentence
    assert found.parameters == {"range_max": 7.9}


@pytest.mark.parametrize("place", [0.01, 0.001])
def test_real_walls_at_the_greatest_range_are_no_code(clean: ScanLog, place: float) -> None:
    """A noiseless robot stands before a wall; what does not return is infinite, as the sensor's driver says."""
    scan = np.round(clean.ranges[:1] / place) * place
    seen = np.repeat(scan, N, axis=0).astype(np.float32)
    assert "readings.max_range" not in named(examine(replace(clean, ranges=seen)))


def test_a_time_increment_that_is_wrong(clean: ScanLog) -> None:
    """All beams were measured at once, but the scans state a sweep that takes as long as the next scan."""
    stated = replace(clean, time_increment=0.4 / (clean.n_beams - 1))
    found = examine(stated)
    assert [one.check for one in found] == ["timing.increment"]
    assert found[0].parameters == {"deskew": "off"}
    assert "0.40 s" in found[0].sentence


def test_drift_that_is_too_little_for_a_finding_is_nothing_that_moved(clean: ScanLog) -> None:
    poses = clean.trajectory().poses.copy()
    poses[N // 2 :, 0] += 0.12
    found = examine(with_poses(clean, poses))
    assert "walls.moving" not in named(found)


def test_beams_that_see_the_robot(clean: ScanLog) -> None:
    ranges = clean.ranges.copy()
    ranges[:, 55:60] = 0.31
    found = the(examine(replace(clean, ranges=ranges)), "readings.itself")
    assert found.sentence.startswith("5 beams around -9°")
    assert "0.31 m" in found.sentence


@pytest.mark.parametrize(
    ("over", "yaw"), [(True, 0.0), (False, np.pi), (False, np.pi / 2), (False, -np.pi / 2), (True, np.pi / 2)]
)
def test_a_laser_that_is_turned(clean: ScanLog, over: bool, yaw: float) -> None:
    # The log claims a mount from which the true one is reached by this correction.
    claimed = compose((0.0, 0.0, 0.0), (0.0, 0.0, -yaw))
    log = replace(clean, mount=(float(claimed[0]), float(claimed[1]), float(claimed[2])), upside_down=over)
    found = the(examine(log), "mount.turned")
    assert found.parameters is not None
    assert found.parameters["mount_upside_down"] == over
    error = (float(found.parameters["mount_yaw"]) - yaw + np.pi) % (2 * np.pi) - np.pi
    assert abs(error) < 0.01


def with_mounts(log: ScanLog, right: Callable[[np.ndarray], np.ndarray], other: tuple[float, float, float]) -> ScanLog:
    """A log that states its own mount at the scans that are ``right``, of their numbers, and another at the rest."""
    is_right = right(np.arange(log.n_scans))[:, np.newaxis]
    return replace(log, mounts=np.where(is_right, log.mount, compose(log.mount, other)))


@pytest.mark.parametrize("other", [(0.0, 0.0, 0.35), *also_long((0.3, 0.2, 0.0), (0.0, 0.0, np.pi))])
def test_a_mount_that_is_stated_in_two_ways_in_turns(clean: ScanLog, other: tuple[float, float, float]) -> None:
    """As where two programs publish the sensor's static transform; drift and pushes that follow are not named."""
    log = with_mounts(clean, lambda k: k // 10 % 2 == 0, other)
    found = diagnose(replace(log, trajectories={"odom": replace(log.trajectory(), frame_id="odom")}))
    assert [one.check for one in found.findings] == ["mount.changing"]
    x, y, yaw = clean.mount
    assert f"{x:.2f} m ahead, {y:.2f} m to the left and turned by {np.degrees(yaw):.1f}°" in found.findings[0].sentence
    assert found.events == ()


def test_a_sensor_that_was_moved_is_no_mount_in_turns(clean: ScanLog) -> None:
    """The first half is seen by a lidar that stood elsewhere, as the log says."""
    n = clean.n_scans
    before = np.arange(n) < n // 2
    mounts = np.where(before[:, np.newaxis], compose(clean.mount, (0.0, 0.0, 0.5)), clean.mount)
    poses = clean.trajectory().poses.copy()
    poses[before] = compose(compose(poses[before], np.array(clean.mount)), inverse(mounts[before]))
    assert "mount.changing" not in named(examine(replace(with_poses(clean, poses), mounts=mounts)))


@pytest.mark.parametrize(
    "offset", [(0.1, 0.1, -0.04), *also_long((0.15, 0.0, 0.0), (0.0, -0.12, 0.0), (0.0, 0.0, 0.06))]
)
def test_a_mount_that_is_a_little_off(clean: ScanLog, offset: tuple[float, float, float]) -> None:
    log = replace(clean, mount=(-offset[0], -offset[1], -offset[2]))
    found = the(examine(log), "mount.offset")
    assert found.parameters is not None
    corrected = compose(log.mount, [found.parameters[name] for name in ("mount_x", "mount_y", "mount_yaw")])
    assert np.hypot(*corrected[:2]) < 0.06
    assert abs(corrected[2]) < 0.015


@pytest.mark.parametrize("mount", [(0.1, 0.25, 0.5), (-0.2, 0.1, np.pi), *also_long((-0.3, 0.2, 2.2), (0.0, 0.0, 1.0))])
def test_a_mount_that_the_log_does_not_state(clean: ScanLog, mount: tuple[float, float, float]) -> None:
    """Recordings without /tf_static: walls are double, and no SLAM mends that. Any mount is looked for."""
    x, y, yaw = inverse(mount)
    log = replace(clean, mount=(float(x), float(y), float(yaw)), mount_assumed=True)
    found = first_cause(log, None, MappingConfig())
    assert found is not None
    assert found.check == "mount.offset"
    assert found.parameters is not None
    at = np.array([found.parameters[name] for name in ("mount_x", "mount_y", "mount_yaw")])
    assert np.hypot(*(at - mount)[:2]) < 0.06
    assert abs(np.sin((at - mount)[2])) < 0.03


def test_a_mount_that_is_assumed_rightly_is_no_cause(clean: ScanLog) -> None:
    assert first_cause(replace(clean, mount_assumed=True), None, MappingConfig()) is None


@pytest.mark.parametrize(("late", "off"), [(0.6, 0.95), (0.95, 0.6), (0.9, None), (None, 0.9), (None, None)])
def test_of_a_delay_and_an_offset_the_one_that_helps_more_is_the_cause(
    clean: ScanLog, monkeypatch: pytest.MonkeyPatch, late: float | None, off: float | None
) -> None:
    """To a robot that drives straight on, both are alike."""
    found = {"timing.delay": late, "mount.offset": off}
    sure = {name: value for name, value in found.items() if value is not None}
    made = {name: [Finding(name, "So.", "", sure[name])] if name in sure else [] for name in found}
    monkeypatch.setattr("mapper.diagnosis.timing.check", lambda *_: made["timing.delay"])
    monkeypatch.setattr("mapper.diagnosis.mounting.check_offset", lambda *_: made["mount.offset"])
    best = max(sure, key=lambda name: sure[name]) if sure else None
    assert named(examine(clean)) & set(found) == ({best} if best else set())


@pytest.mark.parametrize("delay", [-0.5, *also_long(0.3)])
def test_poses_that_are_late(clean: ScanLog, delay: float) -> None:
    times = clean.stamps_ns * 1e-9
    poses = clean.trajectory().poses
    columns = (poses[:, 0], poses[:, 1], np.unwrap(poses[:, 2]))
    late = np.stack([np.interp(times - delay, times, column) for column in columns], axis=-1)
    found = the(examine(with_poses(clean, late)), "timing.delay")
    assert ("after" if delay > 0 else "before") in found.sentence
    assert found.parameters is not None
    offset = found.parameters["time_offset"]
    assert offset == pytest.approx(delay, abs=0.06)
    assert f"--time-offset {offset:g}" in found.advice
    assert "timing.delay" not in named(examine(with_poses(clean, late), time_offset=offset))


def test_scans_that_are_swept_are_judged_from_the_middle_of_their_sweep(clean: ScanLog) -> None:
    """A lidar that turns slowly, stamped at its first beam: without its time increment the poses seem to be early."""
    sweep = 0.4
    times = clean.stamps_ns * 1e-9
    poses = clean.trajectory().poses
    columns = (poses[:, 0], poses[:, 1], np.unwrap(poses[:, 2]))
    first = np.stack([np.interp(times - sweep / 2, times, column) for column in columns], axis=-1)
    stamped = replace(with_poses(clean, first), stamps_ns=clean.stamps_ns - int(sweep / 2 * 1e9))
    assert the(examine(stamped), "timing.delay").parameters == {"time_offset": pytest.approx(sweep / 2, abs=0.06)}
    known = replace(stamped, time_increment=sweep / (clean.n_beams - 1))
    assert "timing.delay" not in named(examine(known))


def test_a_wrong_sweep_is_the_cause_that_map_names(clean: ScanLog) -> None:
    """Drift is looked for without the motion within a scan, and there is none."""
    stated = replace(clean, time_increment=0.4 / (clean.n_beams - 1))
    found = first_cause(stated, None, MappingConfig())
    assert (found.check if found else None) == "timing.increment"
    assert first_cause(stated, None, MappingConfig(deskew="off")) is None


def test_a_sweep_that_is_stamped_at_its_end_is_the_cause_that_map_names() -> None:
    """As drivers do that stamp a scan when it has come (ros2_ouster_drivers issue 127): walls are wide, not double."""
    drive = sample_log(N, "office")
    begun = swept(replace(drive, trajectories={TRUE: drive.trajectory("true")}), "office")
    assert first_cause(begun, TRUE, MappingConfig()) is None
    took = begun.time_increment * begun.n_beams
    poses = Motion.of(begun, TRUE).at(seconds(begun) + took)
    ended = replace(begun, stamps_ns=begun.stamps_ns + int(took * 1e9), trajectories={TRUE: Trajectory(poses)})
    found = first_cause(ended, TRUE, MappingConfig())
    assert found is not None
    assert found.parameters == {"time_offset": pytest.approx(-took, abs=0.05)}


@pytest.mark.parametrize(("sure", "named_check"), [(POSSIBLE, sweep.CHECK), (POSSIBLE - 0.1, None)])
def test_a_sweep_that_is_only_possibly_wrong_is_not_named_with_the_map(
    clean: ScanLog, monkeypatch: pytest.MonkeyPatch, sure: float, named_check: str | None
) -> None:
    unsure = Finding(sweep.CHECK, "It may be wrong.", "", sure)
    monkeypatch.setattr("mapper.diagnosis.drifting.causes_of_drift", lambda *_: [unsure])
    found = first_cause(clean, None, MappingConfig())
    assert (found.check if found else None) == named_check


def test_poses_are_not_said_to_drift_where_the_beams_angles_are_a_guess(clean: ScanLog) -> None:
    """Beams at wrong angles contradict each other along true poses too, so that nothing tells drift."""
    drifting = with_poses(clean, drifting_odometry(clean.trajectory().poses, np.random.default_rng(3)))
    assert "walls.drift" in named(examine(drifting))
    guess = replace(drifting, angles_assumed=True)
    assert "walls.drift" not in named(examine(guess))


def test_poses_that_stay_are_the_cause_that_map_names(clean: ScanLog) -> None:
    poses = np.zeros((clean.n_scans, 3))
    for placeholder in (False, True):  # the latter has a note of its own
        still = replace(clean, trajectories={"odom": Trajectory(poses, is_placeholder=placeholder)})
        found = first_cause(still, None, MappingConfig())
        assert (found.check if found else None) == (None if placeholder else "poses.still")
    one = clean.take(np.zeros(40, dtype=np.int64))
    standing = replace(one, trajectories={"odom": Trajectory(np.zeros((40, 3)))})
    assert first_cause(standing, None, MappingConfig()) is None


def test_a_robot_that_moved_without_poses(clean: ScanLog) -> None:
    found = examine(with_poses(clean, np.zeros((N, 3))))
    assert named(found) == {"poses.still"}
    assert "odometry" in the(found, "poses.still").advice


def test_a_robot_that_stood_still_is_not_blamed(clean: ScanLog) -> None:
    rng = np.random.default_rng(4)
    seen = np.repeat(clean.ranges[:1], N, axis=0) + rng.normal(0.0, 0.01, clean.ranges.shape).astype(np.float32)
    poses = np.repeat(clean.trajectory().poses[:1], N, axis=0)
    assert "poses.still" not in named(examine(with_poses(replace(clean, ranges=seen), poses)))


def test_odometry_that_drifts(clean: ScanLog) -> None:
    poses = drifting_odometry(clean.trajectory().poses, np.random.default_rng(3))
    found = examine(with_poses(clean, poses))
    drift = the(found, "walls.drift")
    assert drift.scans
    assert max(drift.scans) < N


def test_a_removed_table(clean: ScanLog) -> None:
    world = WORLDS["room"]
    # A robot that stays in one room sees the table's place before and after.
    table = np.array([[2.0, 2.0], [3.0, 2.0], [3.0, 2.6], [2.0, 2.6]]) + _free_place(world)
    full = World(world.name, world.title, world.bounds, (*world.solids, table), world.start)
    sensor = SensorConfig(n_beams=360, range_max=8.0, scan_rate=2.5)
    readings, poses, stamps = [], [], []
    simulation = Simulation(full, sensor, 2)
    for part, now in enumerate((full, world)):
        if part:
            simulation.alter_world(now)
        for scan, pose in simulation.advance(60.0):
            readings.append(scan.ranges)
            poses.append(pose)
            stamps.append(scan.stamp_ns)
    log = ScanLog(
        np.array(readings),
        sensor.angle_min,
        sensor.angle_increment,
        0.02,
        8.0,
        np.array(stamps),
        {"true": Trajectory(np.array(poses))},
    )
    found = the(examine(log), "walls.moving")
    assert "went" in found.sentence
    middle = table.mean(axis=0)
    x, y = (float(v) for v in found.sentence.split("(")[1].split(")")[0].split(","))
    assert np.hypot(x - middle[0], y - middle[1]) < 0.8
    assert len(readings) * 0.35 < found.scans[0] < len(readings) * 0.85


def _free_place(world: World) -> np.ndarray:
    """The shift that brings the table into the open, away from where the robot begins."""
    x0, y0, x1, y1 = world.bounds
    xs, ys = np.meshgrid(np.linspace(x0, x1, 60), np.linspace(y0, y1, 60))
    places = np.stack([xs.ravel(), ys.ravel()], axis=-1)
    far = np.hypot(*(places - np.array(world.start[:2])).T) > 1.5
    best = places[np.argmax(np.where(far, world.clearance(places), -1.0))]
    return np.asarray(best - np.array([2.5, 2.3]))


def test_a_log_that_is_too_short_is_not_judged(clean: ScanLog) -> None:
    few = replace(
        clean,
        ranges=clean.ranges[:5],
        stamps_ns=clean.stamps_ns[:5],
        trajectories={"true": Trajectory(clean.trajectory().poses[:5])},
    )
    with pytest.raises(ConfigError, match="too short"):
        examine(few)
    with pytest.raises(ConfigError, match="no trajectory"):
        examine(clean, "slam")


@pytest.mark.parametrize("away", [0.25, 0.6, 1.4])
@pytest.mark.parametrize("yaw", [0.0, 0.6])
def test_a_wall_along_which_the_robot_drives_is_no_part_of_the_robot(away: float, yaw: float) -> None:
    """A straight drive at one distance from the wall of a room of 10 × 7 m, all of whose beams abeam read the same."""
    n, bearings = 80, np.radians(np.arange(-180.0, 180.0))
    x = np.linspace(1.0, 8.5, n)[:, np.newaxis]
    with np.errstate(divide="ignore"):
        along = np.where(np.cos(bearings) > 0.0, 10.0 - x, -x) / np.cos(bearings)
        across = np.where(np.sin(bearings) > 0.0, 7.0 - away, -away) / np.sin(bearings)
    noise = np.random.default_rng(1).normal(0.0, 0.004, (n, 360))
    poses = compose(np.array([0.0, 0.0, yaw]), np.column_stack([x, np.full(n, away), np.zeros(n)]))
    log = ScanLog(
        (np.minimum(along, across) + noise).astype(np.float32), -np.pi, np.radians(1.0), 0.05, 30.0,
        (np.arange(n) * 2e8).astype(np.int64), {"odom": Trajectory(poses, frame_id="odom")},
    )  # fmt: skip
    assert readings.check(log, examined(log)) == []
    ranges = log.ranges.copy()
    ranges[:, 268:273] = 0.31
    own = replace(log, ranges=ranges)
    (found,) = readings.check(own, examined(own))
    assert found.sentence.startswith("5 beams around 90° read 0.31 m")
