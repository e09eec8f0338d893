"""What a scene shows of a session: values that later ticks do not change."""

from __future__ import annotations

import asyncio
import time
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mapper.grid import GridGeometry
from mapper.simulation import WORLDS, World
from server.scenes.belief import Picture, picture
from server.scenes.drawing import beam_segments
from server.sessions import SessionHost
from server.sessions.view import Pose


@dataclass(frozen=True, slots=True)
class Choice:
    """A named choice that a session offers: its label, its names, the current one, and the command that sets it."""

    label: str
    names: tuple[str, ...]
    current: str
    command: str


@dataclass(frozen=True, slots=True)
class SceneState:
    """The state of a session between two ticks.

    ``read_at`` is when it was read, in seconds of :func:`time.monotonic`. ``picture`` is None where the map was not
    read. ``beams`` (n, 2, 3) are in the base frame; ``path`` (n, 3) holds the poses of a log's base, None for a
    simulation. ``sensor`` is None for a log.
    """

    read_at: float
    geometry: GridGeometry
    picture: Picture | None
    pose: Pose
    beams: NDArray[np.float32]
    path: NDArray[np.float64] | None
    world: World | None
    config: dict[str, Any]
    sensor: dict[str, Any] | None
    choice: Choice | None
    playing: bool
    index: int
    count: int


async def read_state(session: SessionHost, *, with_map: bool) -> SceneState:
    """Read the state of a session under its lock (event loop). The map's picture is computed on a thread."""
    async with session.still():
        read_at, view = time.monotonic(), session.model.view()
        shown = None
        if with_map:
            shown = await asyncio.to_thread(picture, view.geometry, view.log_odds, view.observed)
        return SceneState(
            read_at=read_at,
            geometry=view.geometry,
            picture=shown,
            pose=view.pose,
            beams=beam_segments(view),
            path=_path_of(session),
            world=view.world,
            config=asdict(view.config),
            sensor=None if view.sensor is None else asdict(view.sensor),
            choice=_choice_of(session),
            playing=view.playing,
            index=view.index,
            count=view.count,
        )


def _choice_of(session: SessionHost) -> Choice | None:
    """Return the choice of a world, or of a log's trajectory where it has several."""
    recording = session.model.recording
    if recording is not None:
        names = tuple(recording.log.trajectories)
        return Choice("Trajectory", names, recording.trajectory, "trajectory") if len(names) > 1 else None
    world = session.model.view().world
    return Choice("World", tuple(WORLDS), world.name if world else "", "world")


def _path_of(session: SessionHost) -> NDArray[np.float64] | None:
    recording = session.model.recording
    return None if recording is None else recording.log.trajectory(recording.trajectory).poses
