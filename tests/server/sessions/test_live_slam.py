"""SLAM of a simulated robot while it drives with drifting wheels."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

from mapper.core.errors import WorkCancelledError
from mapper.grid import OccupancyGrid
from mapper.mapping.integrate import integrate_log
from mapper.simulation import WORLDS, Faults, SensorConfig
from mapper.simulation.live_map import LiveMap
from server.parts.slam.live import SlamView
from server.parts.slam.live_slam import LiveSlam, live_slam
from server.sessions import SessionRegistry
from server.sessions.tick import TickResult
from server.sources.history import Replayable
from server.stream.commands import FaultsCommand
from tests.server.begin import new_simulation
from tests.server.view import view_of

HEALED = Faults(drift=True, slam=True)


def driven(seconds: float, faults: Faults, world: str = "room", sensor: SensorConfig | None = None) -> LiveMap:
    mapper = LiveMap(WORLDS[world], seed=1, sensor=sensor, make_corrector=live_slam)
    mapper.set_up(mapper.config, faults)
    for _ in range(round(2 * seconds)):
        mapper.advance(0.5)
    return mapper


def errors(mapper: LiveMap, trajectory: str) -> np.ndarray:
    log = mapper.logs()[-1]
    off = log.trajectory(trajectory).poses - log.trajectory("true").poses
    return np.hypot(off[:, 0], off[:, 1])


def test_the_poses_are_right_although_the_wheels_drift_and_the_map_is_made_with_them() -> None:
    mapper = driven(45.0, HEALED)
    assert errors(mapper, "odometry").max() > 0.5
    assert errors(mapper, "slam").max() < 0.1
    assert np.hypot(*(np.array(mapper.believed_pose) - mapper.newest_pose)[:2]) < 0.1
    slam = mapper.pose_correction.corrector_of(mapper.recordings[-1])
    assert isinstance(slam, LiveSlam)
    np.testing.assert_allclose(slam.newest, slam.poses[-1], atol=1e-12)
    # The map is that of the whole recording along its present poses, however often they were corrected.
    mapper.remake(mapper.config)
    made = OccupancyGrid(mapper.grid.geometry, mapper.config.log_odds_prior)
    integrate_log(made, mapper.logs()[-1], mapper.config, "slam")
    np.testing.assert_array_equal(mapper.grid.log_odds, made.log_odds)
    view = SlamView(mapper)
    view.changed(TickResult())
    path, graph = view.layers
    assert (graph.name, path.name) == ("slam", "true_path")
    mapper.set_up(mapper.config, Faults(drift=True))
    view.note(FaultsCommand({"slam": False}), TickResult())
    assert not view.is_on
    assert view.layers == ()


def test_switched_on_later_it_gives_the_same_poses_and_can_be_interrupted() -> None:
    early = driven(12.0, HEALED)
    late = driven(12.0, Faults(drift=True))
    asked = iter([True] * 3 + [False])
    late.may_continue = lambda: next(asked, True)
    with pytest.raises(WorkCancelledError):
        late.set_up(late.config, HEALED)
    assert late.faults == Faults(drift=True)
    late.set_up(late.config, HEALED)
    np.testing.assert_array_equal(late.logs()[-1].trajectory("slam").poses, early.logs()[-1].trajectory("slam").poses)
    np.testing.assert_array_equal(late.grid.log_odds, early.grid.log_odds)


def test_a_robot_that_was_carried_is_where_it_was_put() -> None:
    mapper = driven(12.0, HEALED)
    x, y, _ = WORLDS["room"].start
    mapper.teleport(x + 1.5, y, 0.3)
    mapper.advance(1.0)
    assert errors(mapper, "slam")[-1] < 0.1


def test_a_sonar_follows_its_wheels() -> None:
    mapper = driven(1.5, HEALED, sensor=SensorConfig(kind="sonar_ring"))
    log = mapper.logs()[-1]
    np.testing.assert_allclose(log.trajectory("slam").poses, log.trajectory("odometry").poses, atol=1e-9)
    # A lidar goes on from there.
    mapper.set_sensor(SensorConfig())
    mapper.advance(1.0)
    assert isinstance(mapper.pose_correction.corrector_of(mapper.recordings[-1]), LiveSlam)


async def test_a_session_and_its_copy_have_the_same_healed_map(
    registry: SessionRegistry, obey: Callable[..., Any]
) -> None:
    session = await new_simulation(registry, "me", "room", seed=1)
    await obey(session, type="pause")
    await obey(session, type="step", scans=60)
    await obey(session, type="faults", values={"drift": True, "slam": True})
    assert [layer.name for layer in session.model.layers] == ["map", "true_path", "slam"]
    assert all(layer.number > 0 for layer in session.model.layers[1:])
    history = await session.model.find(Replayable).present_history()
    assert history.faults == {"drift": True, "slam": True}
    copy = await new_simulation(registry, "somebody", history.world, history.seed, history)
    np.testing.assert_array_equal(view_of(copy).log_odds, view_of(session).log_odds)
    await obey(session, type="faults", values={"slam": False})
    assert [layer.name for layer in session.model.layers] == ["map"]
