"""A simulation with faults, a second map beside the first, watched edits, and replayed stories."""

from __future__ import annotations

import json
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from pydantic import ValidationError

from mapper.core.errors import ConfigError, LimitError, MapperError
from mapper.grid import OccupancyGrid
from mapper.mapping.integrate import integrate_log
from mapper.mapping.parameters import MappingConfig
from mapper.simulation import WORLDS, Drawn, Edits, Faults, SensorConfig
from mapper.simulation.live_map import SNAP_M, LiveMap
from server.sessions import SessionRegistry
from server.sources.history import Replayable, SimulationHistory
from server.sources.simulation_replay import history_of, replayed
from server.stream.commands import AutoCommand
from server.stream.grid_layer import GridLayer
from tests.server.begin import new_simulation
from tests.server.view import view_of


def by_hand(mapper: LiveMap, grid: OccupancyGrid, config: MappingConfig, faults: Faults) -> OccupancyGrid:
    """Make a map of the recordings on the lattice of ``grid``."""
    made = OccupancyGrid(grid.geometry, config.log_odds_prior)
    for recording in mapper.recordings:
        integrate_log(made, recording.as_log(specular=faults.specular), config, faults.trajectory)
    return made


@pytest.mark.parametrize("values", [{"drift": True}, {"specular": True}, {"drift": True, "specular": True}])
def test_a_map_with_faults_equals_its_recomputation(values: dict[str, bool]) -> None:
    mapper = LiveMap(WORLDS["room"], seed=1)
    honest = mapper.grid.log_odds.copy()
    mapper.set_up(mapper.config, Faults(**values))
    assert (mapper.grid.log_odds.shape != honest.shape) or np.any(mapper.grid.log_odds != honest)
    mapper.compare({})
    mapper.advance(8.0)
    expected = by_hand(mapper, mapper.grid, mapper.config, Faults(**values))
    np.testing.assert_array_equal(mapper.grid.log_odds, expected.log_odds)
    # The second map is made right of the same recording, scan by scan as well.
    assert mapper.second is not None
    right = by_hand(mapper, mapper.second.grid, mapper.config, Faults())
    np.testing.assert_array_equal(mapper.second.grid.log_odds, right.log_odds)
    mapper.set_up(mapper.config, Faults())
    np.testing.assert_array_equal(mapper.second.grid.observed.sum(), mapper.grid.observed.sum())


def test_sonars_beside_polished_walls_measure_too_far() -> None:
    mapper = LiveMap(WORLDS["office"], seed=1, sensor=SensorConfig(kind="sonar_ring"))
    mapper.set_up(mapper.config, Faults(specular=True))
    mapper.advance(8.0)
    recording = mapper.recordings[-1]
    true, heard = recording.as_log().ranges, recording.as_log(specular=True).ranges
    assert (heard >= true).all()
    assert 0.05 < np.mean(np.isinf(heard) & np.isfinite(true)) < 0.7
    assert np.mean(np.isfinite(heard) & (heard > true + 0.2)) > 0.001
    expected = by_hand(mapper, mapper.grid, mapper.config, mapper.faults)
    np.testing.assert_array_equal(mapper.grid.log_odds, expected.log_odds)


def test_drift_makes_more_walls_than_there_are() -> None:
    mapper = LiveMap(WORLDS["loop"], seed=1)
    mapper.advance(60.0)
    right = int(np.count_nonzero(mapper.grid.log_odds > 0.0))
    mapper.set_up(mapper.config, Faults(drift=True))
    assert np.count_nonzero(mapper.grid.log_odds > 0.0) > 1.3 * right
    assert mapper.believed_pose == mapper.newest_pose  # of the scan that was taken before
    mapper.advance(0.2)
    off = np.subtract(mapper.believed_pose, mapper.newest_pose)
    assert np.hypot(*off[:2]) > 0.3
    mapper.teleport(*mapper.plan.start)
    assert mapper.believed_pose == pytest.approx(mapper.newest_pose)  # who is put somewhere is told where


def test_the_second_map_follows_the_first_ones_parameters() -> None:
    mapper = LiveMap(WORLDS["room"], seed=1)
    mapper.compare({"clamp": False})
    mapper.remake(mapper.config.with_values({"log_odds_hit": 1.5, "resolution": 0.1}))
    assert mapper.second is not None
    assert (mapper.second.config.log_odds_hit, mapper.second.config.clamp) == (1.5, False)
    assert mapper.second.grid.geometry.resolution == 0.1
    assert mapper.second.grid.log_odds.max() > 3.5 >= mapper.grid.log_odds.max()
    mapper.begin(WORLDS["maze"], mapper.simulation.sensor)
    mapper.advance(1.0)
    expected = by_hand(mapper, mapper.second.grid, mapper.second.config, Faults())
    np.testing.assert_array_equal(mapper.second.grid.log_odds, expected.log_odds)
    mapper.compare(None)
    assert mapper.second is None


def test_a_second_map_that_makes_no_sense_is_refused() -> None:
    mapper = LiveMap(WORLDS["room"], seed=1)
    with pytest.raises(ConfigError):
        mapper.compare({"clamp": "perhaps"})
    assert mapper.second is None


def table(mapper: LiveMap) -> Edits:
    """A table 1.2 m before a robot that stands."""
    mapper.simulation.auto = False
    mapper.teleport(4.0, 5.0, 0.0)
    edits = Edits((Drawn("box", 520, 470, 580, 530),))
    mapper.edit(edits)
    mapper.step(40)
    return edits


def test_a_table_is_forgotten_sooner_with_the_clamp() -> None:
    mapper = LiveMap(WORLDS["room"], seed=3)
    table(mapper)
    mapper.edit(Edits(), watch=True)
    assert mapper.vanishing is not None
    assert mapper.second is not None
    assert mapper.second.config.clamp is False
    for _ in range(300):
        mapper.step(1)
        if mapper.vanishing.second.after is not None:
            break
    with_clamp, without = mapper.vanishing.first.after, mapper.vanishing.second.after
    assert with_clamp is not None
    assert without is not None
    assert 3 <= with_clamp <= 20
    assert without > 3 * with_clamp
    # Every count is of the maps themselves: the cells are free there now.
    for grid, way in ((mapper.grid, mapper.vanishing.first), (mapper.second.grid, mapper.vanishing.second)):
        rows, cols = grid.geometry.world_to_cell(way.places).T
        assert np.mean(grid.log_odds[rows, cols] < np.log(0.25 / 0.75)) >= 0.9


def test_a_change_of_parameters_ends_the_count() -> None:
    mapper = LiveMap(WORLDS["room"], seed=3)
    table(mapper)
    mapper.edit(Edits(), watch=True)
    mapper.step(2)
    mapper.remake(mapper.config.with_values({"log_odds_hit": 0.5}))
    assert mapper.vanishing is None


def test_solids_that_the_map_never_showed_cannot_be_forgotten() -> None:
    mapper = LiveMap(WORLDS["office"], seed=3)
    edits = Edits((Drawn("box", 1700, 1250, 1720, 1270),))
    mapper.edit(edits)
    with pytest.raises(ConfigError, match="nothing to forget"):
        mapper.edit(Edits(), watch=True)
    assert mapper.edits == edits
    assert mapper.second is None


ACTS: tuple[dict[str, Any], ...] = (
    {"type": "teleport", "x": 6.0, "y": 6.2},
    {"type": "sensor", "values": {"n_beams": 90}},
    {"type": "drive", "linear": 0.5, "angular": 0.4},
    {"type": "edit", "added": [["box", 300, 300, 340, 360]], "erased": [9]},
    {"type": "auto", "value": True},
)


async def test_replaying_a_story_gives_the_same_map(registry: SessionRegistry, obey: Callable[..., Any]) -> None:
    session = await new_simulation(registry, "me", "room", seed=4)
    await obey(session, type="pause")
    for command in ACTS:
        await obey(session, **command)
        await obey(session, type="step", scans=13)
    await obey(session, type="parameters", values={"window": 0.35, "clamp": False})
    await obey(session, type="faults", values={"drift": True})
    history = await session.model.find(Replayable).present_history()
    assert len(history.journal) == len(ACTS)
    sent = json.loads(history.model_dump_json())
    other = await new_simulation(registry, "somebody", history.world, history.seed, sent)
    here, there = view_of(session), view_of(other)
    assert there.pose == here.pose
    assert there.config == here.config
    assert there.count == here.count
    np.testing.assert_array_equal(there.ranges, here.ranges)
    np.testing.assert_array_equal(there.log_odds, here.log_odds)
    assert [s.tobytes() for s in there.world.solids] == [s.tobytes() for s in here.world.solids]  # type: ignore[union-attr]
    assert await other.model.find(Replayable).present_history() == history


def test_a_story_that_is_too_long_begins_at_the_present_state() -> None:
    mapper = LiveMap(WORLDS["room"], seed=3)
    for i in range(1001):
        mapper.journal.append((i, AutoCommand(value=True)))
    mapper.edit(Edits((Drawn("box", 520, 470, 580, 530),)))
    mapper.teleport(4.0, 5.0, 1.0)
    history = history_of(mapper)
    assert history.journal is None
    other = replayed(SimulationHistory.model_validate_json(history.model_dump_json()))
    assert other.simulation.pose == pytest.approx((4.0, 5.0, 1.0))
    assert other.edits == mapper.edits


BAD: dict[str, tuple[dict[str, Any], type[Exception]]] = {
    "many": ({"journal": [[0, {"type": "auto", "value": True}]] * 1001}, ValidationError),
    "long": ({"journal": [], "steps": 10**6}, LimitError),
    "action": ({"journal": [[0, {"type": "restart"}]], "steps": 100}, MapperError),
    "nothing": ({"journal": [[0, {}]], "steps": 100}, MapperError),
    "place": ({"journal": [[0, {"type": "teleport", "x": "a", "y": 1}]], "steps": 100}, MapperError),
    "sensor": ({"sensor": {"n_beams": 1}}, ConfigError),
    "parameter": ({"parameters": {"window": -1}}, ConfigError),
    "fault": ({"faults": {"fire": True}}, ConfigError),
    "speed": ({"speed": 1000.0}, ConfigError),
    "edits": ({"edits": {"added": [["box"]]}}, ConfigError),
}


@pytest.mark.parametrize(("story", "error"), BAD.values(), ids=BAD)
async def test_a_story_that_makes_no_sense_is_refused(
    registry: SessionRegistry, story: dict[str, Any], error: type[Exception]
) -> None:
    with pytest.raises(error):
        await new_simulation(registry, "me", "room", 1, story)
    assert len(registry) == 0


async def test_subscribers_of_the_second_map_receive_it(registry: SessionRegistry, obey: Callable[..., Any]) -> None:
    session = await new_simulation(registry, "me", "room", seed=4)
    client = session.join()
    client.subscribe(["second_map"])
    await obey(session, type="compare", values={"log_odds_hit": 0.2})
    await obey(session, type="step", scans=3)
    shown = (layer.picture for layer in session.model.layers if isinstance(layer, GridLayer))
    first, second = (picture.cells for picture in shown if picture is not None)
    assert first.shape == second.shape
    assert np.any(first != second)
    texts = [message for message in client.take() if isinstance(message, str)]
    assert {json.loads(text)["type"] for text in texts} >= {"hello", "layers", "geometry", "frame"}


def test_a_robot_that_is_moved_aside_by_little_is_put_there_without_a_word() -> None:
    mapper = LiveMap(WORLDS["room"], seed=1)
    radius, world = mapper.simulation.radius, mapper.simulation.world
    x, y = world.bounds[0] + 0.5 * radius, world.bounds[1] + 5.0  # in or at a wall
    for _ in range(200):  # away from it, until the robot nearly fits
        place = world.nearest_free((x, y), radius + 1e-3)
        if np.hypot(place[0] - x, place[1] - y) < SNAP_M:
            break
        x += 0.01
    assert not world.is_free((x, y), radius + 1e-3)
    assert mapper.teleport(x, y, None)[1] is None
    assert "nearest free spot" in (mapper.teleport(-50.0, -50.0, None)[1] or "")
