"""The motion of the simulated robot, for the table: by the kernel, and step by step in plain Python."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from hypothesis import strategies as st

from mapper.simulation import WORLDS
from mapper.simulation.kernels import driving
from mapper.simulation.textbook_driving import Drive

STEPS = 60


@st.composite
def drives(draw: st.DrawFn) -> tuple[Drive, int, float]:
    """Robots in the open, at walls and inside of them, on paths that lead through walls, end near by, or are empty."""
    rng = np.random.default_rng(draw(st.integers(0, 2**32)))
    world = WORLDS[draw(st.sampled_from(["office", "maze"]))]
    x, y = rng.uniform(world.bounds[:2], world.bounds[2:])
    if draw(st.booleans()):
        x, y = world.nearest_free((x, y), 0.2)
    heading = np.cumsum(rng.normal(0.0, 0.3, draw(st.sampled_from([0, 1, 2, 10, 60])))) + rng.uniform(-4.0, 4.0)
    along = np.cumsum(0.1 * np.stack([np.cos(heading), np.sin(heading)], axis=-1), axis=0)
    path = np.array([x, y]) + rng.normal(0.0, 0.2, 2) + along.reshape(-1, 2)
    pose = (float(x), float(y), float(rng.uniform(-np.pi, np.pi)))
    linear, angular, *commanded = rng.uniform(-1.6, 1.6, 4).tolist()
    progress = (float(x + rng.normal(0.0, 0.08)), float(y), float(rng.uniform(-3.0, 0.0)))
    drive = Drive(world.segments, 0.2, path, pose, pose, linear, angular, (commanded[0], commanded[1]), progress)
    return drive, draw(st.integers(0, 3)), float(rng.uniform(0.0, 0.5))


def driven_by_kernel(case: tuple[Drive, int, float]) -> tuple[Any, ...]:
    drive, first, next_scan = case
    state = np.array([*drive.pose, drive.linear, drive.angular, *drive.commanded, *drive.progress, *drive.before, 0.0])
    known = driving.PATH if len(drive.path) and first % 2 == 0 else driving.VELOCITIES
    out: list[Any] = []
    steps = first
    while steps < STEPS:
        path = drive.path[int(state[driving.FIRST]) :]
        state[driving.FIRST] = 0.0
        count = 1 if known == driving.VELOCITIES else STEPS - steps
        done = driving.drive(drive.segments, drive.radius, path, state, steps, count, next_scan, known, 2.0)
        left = len(path) - int(state[driving.FIRST]) if done else 0
        out += [done, state[: driving.FIRST].copy(), left]
        drive = replace(drive, path=path)
        steps, known = steps + done, driving.NOTHING if done else driving.VELOCITIES
        next_scan += 0.1 if steps * driving.STEP >= next_scan - 1e-9 else 0.0
    return tuple(out)


def driven_by_textbook(case: tuple[Drive, int, float]) -> tuple[Any, ...]:
    drive, first, next_scan = replace(case[0]), *case[1:]
    planned = bool(len(drive.path)) and first % 2 == 0
    given = not planned
    out: list[Any] = []
    steps = first
    while steps < STEPS:
        count = 1 if given else STEPS - steps
        done = drive.drive(steps, count, next_scan, planned=planned, given=given)
        state = [*drive.pose, drive.linear, drive.angular, *drive.commanded, *drive.progress, *drive.before]
        out += [done, np.array(state), len(drive.path) if done else 0]
        steps, planned, given = steps + done, False, not done
        next_scan += 0.1 if steps * driving.STEP >= next_scan - 1e-9 else 0.0
    return tuple(out)
