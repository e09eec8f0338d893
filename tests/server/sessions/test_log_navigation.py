"""The costmap over a log's map and the path on it, against a costmap that is built at once of the same map."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from msgspec import Struct

from mapper.core.errors import ConfigError
from mapper.costmap import LETHAL, cost_of_distance
from mapper.grid import GridGeometry
from mapper.sensors.joint_log import JointLog
from mapper.sensors.scan import ScanLog
from server.library.packs.reference_map import ReferenceMap
from server.parts.costmap import part as costmap_part
from server.parts.costmap.parameters import CostmapParameters
from server.parts.costmap.part import CostmapPart
from server.parts.localization.logged import LogLocalization
from server.parts.terrain.costs import TerrainMap
from server.parts.wire import command_of
from server.sessions import SessionRegistry
from server.sessions.commands import UseCosts, UseTerrain
from server.sessions.tick import TickResult
from server.sources.log import LogModel
from server.stream.protocol import ProtocolError
from tests.server.begin import new_log
from tests.server.sent import sent

STATIC_ONLY = {"obstacle_layer": False, "dynamic_layer": False}


class Log:
    """A log's model without its host's clock."""

    def __init__(self, model: LogModel) -> None:
        self.model = model
        self.answers: list[dict[str, Any]] = []
        self.notices: list[str] = []
        self.said: list[str] = []

    def do(self, **command: Any) -> dict[str, Any]:
        return self.take(command_of(command))

    def take(self, command: Struct) -> dict[str, Any]:
        result = TickResult()
        self.model.handle(command, result)
        while self.model.is_catching_up:
            self.model.advance(0.0, result)
        self.model.draw(result)
        self.answers = sent(answer for _, answer in result.answers)
        self.notices = [notice.code for notice in result.notices]
        self.said = [notice.message for notice in result.notices]
        return sent(self.model.messages())[-1]

    @property
    def localization(self) -> LogLocalization:
        part = self.model.find(LogLocalization)
        assert part is not None
        return part

    @property
    def part(self) -> CostmapPart:
        part = self.model.find(CostmapPart)
        assert part is not None
        return part

    @property
    def costs(self) -> np.ndarray:
        costmap = self.part.costmap
        assert costmap is not None
        return costmap.costs


@pytest.fixture
async def log(registry: SessionRegistry, office_log: ScanLog) -> Log:
    session = await new_log(registry, "me", office_log, playing=False)
    model = session.model
    assert isinstance(model, LogModel)
    return Log(model)


async def test_costs_are_those_of_the_whole_map_at_each_scan(log: Log) -> None:
    parameters = CostmapParameters().with_values(STATIC_ONLY)
    log.do(type="costmap", values=STATIC_ONLY)
    for index in (120, 150, 40):
        log.do(type="seek", index=index)
        grid = log.model.grid
        lethal = grid.classify() == 100
        np.testing.assert_array_equal(log.costs == LETHAL, lethal, err_msg=str(index))
        row, col = (int(v) for v in np.argwhere(lethal)[0])
        inscribed = parameters.outline.inscribed_radius
        near = cost_of_distance(grid.geometry.resolution, inscribed, 3.0)
        around = log.costs[max(row - 1, 0) : row + 2, max(col - 1, 0) : col + 2]
        assert around.min() >= min(near, 253)


SOURCES = """
global_costmap:
  global_costmap:
    ros__parameters:
      robot_radius: 0.2
      plugins: [o]
      o:
        plugin: "nav2_costmap_2d::ObstacleLayer"
        observation_sources: near far
        near: {{topic: {}, max_obstacle_height: 2.0, obstacle_max_range: 0.5}}
        far: {{topic: {}, max_obstacle_height: 2.0, obstacle_max_range: 30.0}}
"""


async def test_of_several_lidars_each_has_the_sources_with_its_topic(
    registry: SessionRegistry, office_log: ScanLog
) -> None:
    """As in Nav2, where each source subscribes to its topic; where none has a topic of the log, the first one's see."""
    both = JointLog.of([replace(office_log, topic=topic) for topic in ("/front", "/rear")])
    session = await new_log(registry, "me", both, playing=False)
    assert isinstance(session.model, LogModel)
    log = Log(session.model)
    log.do(type="costmap", values={"dynamic_layer": False})

    def lethal(near: str, far: str) -> int:
        log.do(type="nav2", text=SOURCES.format(near, far))
        log.do(type="restart")
        for index in range(1, 13):
            log.do(type="seek", index=index)
        return int((log.costs == LETHAL).sum())

    far = lethal("/front", "rear")
    assert far > lethal("/front", "/other") == 0
    assert lethal("/other", "/front") == far
    assert lethal("/none", "/other") == 0
    log.do(type="nav2", text=SOURCES.format("/none", "/other"))
    assert any("o has no source with the topic /front, /rear" in said for said in log.said)


async def test_a_painted_speed_limit_is_told_where_the_robot_is(log: Log) -> None:
    log.do(type="seek", index=120)
    x, y, _ = log.model.recording.robot_state().pose
    zone = {"width": 3.0, "erases": False, "points": [[x, y]], "speed": 40}
    log.do(type="costmap", keepout=[zone])
    limits = []
    for command in ({"type": "seek", "index": 121}, {"type": "costmap", "values": {"speed_limits": "absolute"}}):
        log.do(**command)
        limits += [one["speed_limit"] for one in sent(log.model.messages()) if one["type"] == "path"]
    assert limits == ["40 %", "0.4 m/s"]


async def test_the_newest_scan_marks_and_a_scan_before_it_forgets(log: Log) -> None:
    log.do(type="seek", index=150)
    log.do(type="costmap", values={"static_layer": False, "dynamic_layer": False, "track_unknown_space": False})
    late = log.costs == LETHAL
    robot = log.model.recording.robot_state()
    ranges = robot.scan.ranges
    seen = (ranges >= robot.scan.range_min) & (ranges <= robot.scan.range_max) & (ranges < 4.9)
    assert seen.any()
    x, y, yaw = robot.scan_pose
    at = yaw + robot.scan.angles[seen]
    points = np.column_stack([x + ranges[seen] * np.cos(at), y + ranges[seen] * np.sin(at)])
    cells = log.model.grid.geometry.world_to_cell(points)
    assert late[cells[:, 0], cells[:, 1]].mean() > 0.95
    log.do(type="seek", index=20)
    assert not (log.costs[cells[:, 0], cells[:, 1]] == LETHAL).all()


async def test_the_path_begins_at_the_robot_and_ends_at_the_goal(log: Log) -> None:
    log.do(type="seek", index=150)
    log.do(type="costmap", values=STATIC_ONLY | {"allow_unknown": False})
    goal = log.model.recording.log.trajectory(None).poses[10, :2]
    path = log.do(type="goal", x=float(goal[0]), y=float(goal[1]))
    assert path["reaches_goal"], path
    straight = float(np.hypot(*(log.model.recording.robot_state().pose[:2] - goal)))
    assert path["length"] >= straight - 0.2
    log.do(type="cost", x=float(goal[0]), y=float(goal[1]))
    assert log.answers[0]["layers"][0]["layer"] == "static_layer"
    there_and_back = log.do(type="nav2")
    assert there_and_back["goal"] == path["goal"]
    text = log.answers[0]["text"].replace("inflation_radius: 0.55", "inflation_radius: 0.8")
    log.do(type="nav2", text=text)
    assert sent(log.model.messages())[-2]["values"]["inflation_radius"] == 0.8
    assert log.do(type="costmap", value=False)["goal"] is None
    assert log.part.layers == ()


async def test_the_map_that_was_given_is_the_static_map_with_its_zones(log: Log) -> None:
    """Cell for cell; another map replaces it, and a map without zones has none."""
    log.do(type="seek", index=150)
    with pytest.raises(ConfigError, match="choose one in the group Localize"):
        log.do(type="costmap", values=STATIC_ONLY | {"map": "given"})
    rng = np.random.default_rng(3)
    x, y = log.model.recording.robot_state().pose[:2]
    for rows, keepout in ((40, True), (50, False)):
        geometry = GridGeometry(0.1, rows, 60, (x - 3.0, y - 2.0, 0.0))
        values = rng.choice(np.array([0, 100, -1], np.int8), geometry.shape)
        zones = rng.choice(np.array([0, 50], np.int8), geometry.shape) if keepout else None
        limits = np.full(geometry.shape, 35 if keepout else 0, np.int8)
        log.localization.show_map(ReferenceMap("given", geometry, values, (), zones, limits))
        log.do(type="costmap", values=STATIC_ONLY | {"map": "given", "inflation_layer": False})
        costs = np.select([values == 100, values == 0], [254, 0], 255)
        if zones is not None:
            costs = np.where((zones > 0) & ((costs == 255) | (costs < 127)), 127, costs)
        np.testing.assert_array_equal(log.costs, costs)
        assert sent(log.model.messages())[-1]["speed_limit"] == ("35 %" if keepout else None)
    log.do(type="costmap", values={"map": "belief"})
    assert log.costs.shape == log.model.grid.geometry.shape


async def test_a_costmap_begins_with_the_map_that_the_poses_are_in(log: Log) -> None:
    """As in Nav2 above AMCL: along localized poses the loaded map is the static one, along others the log's own."""
    log.do(type="seek", index=60)
    x, y = log.model.recording.robot_state().pose[:2]
    geometry = GridGeometry(0.1, 40, 60, (x - 3.0, y - 2.0, 0.0))
    values = np.random.default_rng(4).choice(np.array([0, 100, -1], np.int8), geometry.shape)
    log.localization.show_map(ReferenceMap("given", geometry, values, ()))
    log.do(type="costmap", value=True)
    assert sent(log.model.messages())[-2]["values"]["map"] == "belief"
    log.do(type="costmap", value=False)
    recording = log.model.recording
    way = replace(recording.log.trajectory(None), from_scans=True)
    recording.update(replace(recording.log, trajectories={**recording.log.trajectories, "localized": way}))
    log.do(type="trajectory", name="localized")
    log.do(type="costmap", value=True)
    assert sent(log.model.messages())[-2]["values"]["map"] == "given"
    assert log.costs.shape == geometry.shape


async def test_the_terrain_of_a_map_is_a_layer_and_says_why(log: Log) -> None:
    """At the centre of each cell, of a map with other cells; unknown where the map is, or ends."""
    log.do(type="seek", index=150)
    x, y = log.model.recording.robot_state().pose[:2]
    geometry = GridGeometry(0.4, 5, 6, (x - 1.0, y - 1.0, 0.3))
    values = np.random.default_rng(5).choice(np.array([0, 100, -1, 50], np.int8), geometry.shape)
    only = STATIC_ONLY | {"static_layer": False, "inflation_layer": False, "terrain_layer": True}
    assert "terrain_layer" not in [layer.name for layer in log.model.layers]
    log.take(UseCosts(TerrainMap("slopes", ReferenceMap("slopes.yaml", geometry, values))))
    log.do(type="costmap", values=only | {"track_unknown_space": True})
    assert log.notices == []
    own = log.model.grid.geometry
    costs = {0: 0, 100: 254, -1: 255, 50: 127}
    for row, col in np.ndindex(*own.shape):
        at = geometry.world_to_cell(own.cell_to_world((row, col)))
        assert log.costs[row, col] == (costs[int(values[tuple(at)])] if geometry.contains(at) else 255)
    assert "terrain_layer" in [layer.name for layer in log.model.layers]
    unsafe = geometry.cell_to_world(np.argwhere(values == 100)[0])
    log.do(type="cost", x=float(unsafe[0]), y=float(unsafe[1]))
    (reason,) = [one for one in log.answers[0]["layers"] if one["layer"] == "terrain_layer"]
    assert reason["sentence"] == "Terrain: unsafe, in the map 'slopes.yaml'."
    # Begun again it is there again; a map elsewhere is said so, and none leaves no layer.
    log.do(type="costmap", value=False)
    log.do(type="costmap", values=only)
    assert (log.costs == 254).any()
    assert log.part.history()[-1] == UseTerrain("slopes")
    far = ReferenceMap("far.yaml", GridGeometry(0.4, 5, 6, (9e3, 9e3, 0.0)), values)
    log.take(UseCosts(TerrainMap("far", far)))
    assert log.notices == ["terrain.elsewhere"]
    log.take(UseCosts(None))
    assert not (log.costs == 254).any()
    assert "terrain_layer" not in [layer.name for layer in log.model.layers]


async def test_what_a_log_cannot_have_is_refused(log: Log, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(ProtocolError, match="has to be begun first"):
        log.do(type="goal", x=0.0, y=0.0)
    with pytest.raises(ConfigError, match="one of belief, given: it has no map 'plan'"):
        log.do(type="costmap", values={"map": "plan"})
    monkeypatch.setattr(costmap_part, "MOST_CELLS", 10)
    with pytest.raises(ConfigError, match="a costmap at most 10; choose a coarser resolution"):
        log.do(type="costmap")
    assert log.part.layers == ()


async def test_a_map_that_became_too_large_ends_the_costmap_and_not_the_session(
    log: Log, monkeypatch: pytest.MonkeyPatch
) -> None:
    log.do(type="seek", index=150)
    small = ReferenceMap("given", GridGeometry(0.1, 4, 5), np.zeros((4, 5), np.int8))
    log.localization.show_map(small)
    log.do(type="costmap", values=STATIC_ONLY | {"map": "given"})
    monkeypatch.setattr(costmap_part, "MOST_CELLS", 25)
    log.localization.show_map(ReferenceMap("larger", GridGeometry(0.1, 6, 5), np.zeros((6, 5), np.int8)))
    log.do(type="step")
    assert (log.notices, log.costs.shape) == (["costmap.too_large"], (4, 5))
    log.do(type="step")
    assert (log.notices, log.costs.shape) == ([], (4, 5))
    log.localization.show_map(small)
    monkeypatch.undo()
    log.do(type="costmap", values={"map": "belief"})
    monkeypatch.setattr(costmap_part, "MOST_CELLS", 25)
    log.do(type="step")
    assert (log.notices, log.part.layers) == (["costmap.too_large"], ())
