"""The lab's costmap and path: over the map as it grows, around what is in the way, and the robot drives it."""

from __future__ import annotations

import functools
import math
import operator
from collections.abc import AsyncIterator
from typing import Any

import numpy as np
import pytest
import yaml
from msgspec import Struct

from mapper.core.array_types import Int8Array
from mapper.core.errors import ConfigError, MapperError
from mapper.costmap import Footprint, LayeredCostmap, Mask, SpeedFilter
from mapper.costmap.build import build_costmap
from mapper.costmap.nav2.reading import parse_nav2_costmap
from mapper.costmap.parameters import ObstacleConfig
from mapper.io import ros_parameters, untrusted_yaml
from server.parts.costmap.messages import CostmapCommand, Nav2Command
from server.parts.costmap.parameters import CostmapParameters
from server.parts.costmap.part import CostmapPart
from server.parts.wire import command_of
from server.sessions import SessionRegistry
from server.sessions.tick import TickResult
from server.sources.history import History
from server.sources.simulation import SimulationModel
from server.stream.commands import DriveCommand
from server.stream.grid_layer import GridLayer
from server.stream.protocol import ProtocolError
from tests.mapper.planning.nav2_file import parse_nav2_path
from tests.server.begin import new_simulation
from tests.server.sent import sent
from tests.server.service import eventually
from tests.server.sessions.conftest import obeyed

ALL = [
    "costmap",
    "static_layer",
    "obstacle_layer",
    "dynamic_layer",
    "keepout_filter",
    "inflation_layer",
    "speed_filter",
    "plan",
]
STATIC_ONLY = {"obstacle_layer": False, "dynamic_layer": False}
BEYOND = (12.0, 7.0)  # down the corridor
TABLE = ["box", 830, 670, 890, 730]


class Lab:
    """A simulation's model without its host's clock: commands, and ticks of a tenth of a second."""

    def __init__(self, model: SimulationModel) -> None:
        self.model = model
        self.answers: list[dict[str, Any]] = []
        self.notices: list[str] = []
        self.has_changed = False

    def do(self, **command: Any) -> dict[str, Any]:
        result = TickResult()
        self.model.handle(command_of(command), result)
        self.model.draw(result)
        self.answers = sent(answer for _, answer in result.answers)
        self.notices = [notice.code for notice in result.notices]
        self.has_changed = result.changed
        return self.path

    def pass_time(self, seconds: float) -> dict[str, Any]:
        for _ in range(round(10 * seconds)):
            result = TickResult()
            self.model.advance(0.1, result)
            self.model.draw(result)
        return self.path

    @property
    def path(self) -> dict[str, Any]:
        return self.message("path")

    @property
    def costmap(self) -> dict[str, Any]:
        return self.message("costmap")

    def message(self, kind: str) -> dict[str, Any]:
        return next(one for one in sent(self.model.messages()) if one["type"] == kind)

    @property
    def masks(self) -> dict[str, Int8Array]:
        return self.part.present_masks()

    @property
    def part(self) -> CostmapPart:
        part = self.model.find(CostmapPart)
        assert part is not None
        return part

    @property
    def costs(self) -> LayeredCostmap:
        made = self.part.costmap
        assert made is not None
        return made.costmap


@pytest.fixture
async def lab(registry: SessionRegistry) -> AsyncIterator[Lab]:
    session = await new_simulation(registry, "me", "office", 3, playing=False)
    async with session.locked():
        lab = Lab(session.model)
        lab.do(type="auto", value=False)
        lab.do(type="teleport", x=6.2, y=7.0, yaw=0.0)
        yield lab


async def test_it_costs_nothing_until_it_is_begun_and_ends_with_the_world(lab: Lab) -> None:
    assert [layer.name for layer in lab.model.layers] == ["map"]
    before = lab.model.footprint.cells
    for kind in ("goal", "nav2", "cost"):
        with pytest.raises(ProtocolError, match="no costmap"):
            lab.do(type=kind, x=1.0, y=1.0)
    lab.do(type="costmap")
    assert [layer.name for layer in lab.model.layers] == ["map", *ALL]
    assert lab.model.footprint.cells > before
    assert lab.costmap["is_on"]
    lab.do(type="world", name="room")
    assert [layer.name for layer in lab.model.layers] == ["map"]
    assert not lab.costmap["is_on"]


async def test_the_costs_are_those_of_the_library_over_the_whole_map(lab: Lab) -> None:
    lab.do(type="costmap", values=STATIC_ONLY | {"inflation_radius": 0.8})
    lab.do(type="auto", value=True)
    lab.pass_time(4.0)
    # Box by box as the robot mapped, against all layers over the finished map at once.
    grid = lab.model.grid
    parameters = CostmapParameters().with_values(STATIC_ONLY | {"inflation_radius": 0.8})
    whole = build_costmap(grid.geometry, grid.classify(), parameters.stack, parameters.outline).costmap
    whole.update()
    np.testing.assert_array_equal(lab.costs.costs, whole.costs)


async def test_the_path_follows_the_goal_and_the_robot_drives_it(lab: Lab) -> None:
    lab.do(type="costmap", values={"map": "plan"})
    first = lab.do(type="goal", x=BEYOND[0], y=BEYOND[1])
    assert first["reaches_goal"]
    assert first["length"] == pytest.approx(math.dist((6.2, 7.0), BEYOND), rel=0.1)
    inside = lab.do(type="goal", x=8.7, y=7.85)  # in a cabinet: as near as the robot fits
    assert not inside["reaches_goal"]
    assert "cannot be at the goal" in inside["reason"]
    outside = lab.do(type="goal", x=80.0, y=7.0)
    assert outside["length"] is None
    assert "outside the map" in outside["reason"]
    lab.do(type="goal", x=8.0, y=7.0, drives=True)
    assert lab.path["drives"]
    for _ in range(20):
        lab.pass_time(1.0)
        if not lab.path["drives"] or math.dist(lab.model.robot_state().pose[:2], (8.0, 7.0)) < 0.13:
            break
    assert math.dist(lab.model.robot_state().pose[:2], (8.0, 7.0)) < 0.15
    lab.do(type="goal", x=BEYOND[0], y=BEYOND[1], drives=True)
    lab.do(type="drive", linear=0.1, angular=0.0)  # somebody takes the wheel
    assert not lab.path["drives"]


async def test_unknown_cells_are_crossed_only_where_that_is_allowed(lab: Lab) -> None:
    lab.do(type="costmap")
    refused = lab.do(type="goal", x=17.0, y=11.0)  # a room that nobody has seen
    assert refused["length"] is None
    assert "unknown" in refused["reason"]
    lab.do(type="costmap", values={"allow_unknown": True})
    assert lab.path["reaches_goal"], lab.path


async def test_a_table_that_is_taken_away_is_in_the_dynamic_layer_for_its_lifetime(lab: Lab) -> None:
    values = {"map": "plan", "obstacle_layer": False, "clearing": False, "lifetime": 3.0}
    lab.do(type="costmap", values=values)
    straight = lab.do(type="goal", x=BEYOND[0], y=BEYOND[1])["length"]
    lab.do(type="edit", added=[TABLE])
    around = lab.pass_time(0.5)["length"]
    assert around > straight + 0.05
    lab.do(type="edit", added=[])
    assert lab.pass_time(2.0)["length"] == pytest.approx(around, abs=0.05)  # nothing is there any more
    assert lab.pass_time(2.5)["length"] == pytest.approx(straight, abs=0.02)


async def test_without_the_clamp_a_table_stays_in_the_static_layer(lab: Lab) -> None:
    lab.do(type="costmap", values=STATIC_ONLY)
    lab.do(type="sensor", values={"n_beams": 720})  # a beam through each cell
    straight = lab.do(type="goal", x=10.0, y=7.0)["length"]
    (row0, col0), (row1, col1) = lab.costs.geometry.world_to_cell([(8.35, 6.75), (8.85, 7.25)])
    left = {}
    for clamp in (True, False):
        lab.do(type="parameters", values={"clamp": clamp})
        result = TickResult()
        lab.model.settle(result)
        lab.model.draw(result)
        lab.do(type="edit", added=[TABLE])
        lab.pass_time(6.0)
        lab.do(type="edit", added=[])
        around = lab.pass_time(3.0)["length"]
        left[clamp] = int((lab.costs.costs[row0 : row1 + 1, col0 : col1 + 1] == 254).sum())
    assert around > straight + 0.05
    assert left[False] > 10 > left[True]


async def test_keepout_zones_are_painted_erased_and_undone(lab: Lab) -> None:
    lab.do(type="costmap", values={"map": "plan"})
    straight = lab.do(type="goal", x=BEYOND[0], y=BEYOND[1])["length"]
    points = [[9.9, 6.4], [9.9, 7.2]]
    zone: dict[str, Any] = {"width": 0.4, "erases": False, "points": points}
    lab.do(type="costmap", keepout=[zone])
    around = lab.path["length"]
    assert around > straight + 0.02
    assert lab.costmap["keepout"] == [zone]
    grown = zone | {"points": [*points, [9.9, 8.2]]}
    lab.do(type="costmap", keepout=[grown])
    shut = lab.path["length"]
    assert shut is None or shut > around + 1.0  # the corridor is shut: by another way or none
    lab.do(type="costmap", keepout=[grown, grown | {"erases": True, "width": 1.0}])
    assert lab.path["length"] == pytest.approx(straight, abs=0.02)
    lab.do(type="costmap", keepout=[zone])
    assert lab.path["length"] == pytest.approx(around, abs=0.02)
    lab.do(type="costmap", keepout=[])
    assert lab.path["length"] == pytest.approx(straight, abs=0.02)
    for wrong in ([zone | {"width": 9.0}], [zone | {"points": []}], [zone] * 101):
        with pytest.raises(ProtocolError):
            lab.do(type="costmap", keepout=wrong)


async def test_the_robot_drives_slower_where_a_speed_limit_is_painted(lab: Lab) -> None:
    """By the speed filter's formula in percent and in m/s; the path and the costs stay as they were."""

    def speed() -> float:
        before = lab.model.robot_state().pose[0]
        lab.pass_time(0.5)
        return (lab.model.robot_state().pose[0] - before) / 0.5

    zone: dict[str, Any] = {"width": 1.0, "erases": False, "points": [[5.0, 7.0], [13.0, 7.0]], "speed": 40}
    lab.do(type="costmap", values={"map": "plan"})
    straight = lab.do(type="goal", x=BEYOND[0], y=BEYOND[1], drives=True)["cost"]
    lab.pass_time(1.5)
    assert speed() == pytest.approx(0.5, rel=0.05)
    before = lab.costs.costs.copy()
    limited = lab.do(type="costmap", keepout=[zone])
    assert (limited["speed_limit"], limited["reaches_goal"]) == ("40 %: 0.20 m/s", True)
    assert limited["cost"] < straight
    np.testing.assert_array_equal(lab.costs.costs, before)
    lab.pass_time(1.0)
    assert speed() == pytest.approx(0.2, rel=0.05)
    absolute = lab.do(type="costmap", values={"speed_limits": "absolute"}, keepout=[zone | {"speed": 10}])
    assert absolute["speed_limit"] == "0.1 m/s"
    lab.pass_time(1.0)
    assert speed() == pytest.approx(0.1, rel=0.05)
    # Why, as a Nav2 file that names the mask, as the sheet; and erased or switched off it limits no longer.
    lab.do(type="cost", x=9.0, y=7.0)
    assert "0.10 m/s" in lab.answers[0]["speed"]
    lab.do(type="nav2")
    (found,) = parse_nav2_costmap(lab.answers[0]["text"].encode()).filters
    assert (found.kind, found.mask, found.type, found.multiplier) == ("speed", "speed.yaml", 2, 0.01)
    limits = SpeedFilter(Mask(lab.costs.geometry, lab.masks["speed"]), 2, multiplier=0.01)
    assert limits.at(9.0, 7.3).limit == pytest.approx(0.1)
    assert limits.at(9.0, 8.3).limit is None
    off = lab.do(type="costmap", values={"speed_filter": False})
    on = lab.do(type="costmap", values={"speed_filter": True})
    erased = lab.do(type="costmap", keepout=[zone, {"width": 2.0, "erases": True, "points": zone["points"]}])
    assert [one["speed_limit"] for one in (off, on, erased)] == [None, "0.1 m/s", None]
    # Without a limit the whole path is at 0.5 m/s; with it, what lies in the zone takes five times as long.
    assert off["travel_s"] == erased["travel_s"] == pytest.approx(off["length"] / 0.5, rel=1e-2)
    inside = BEYOND[0] - lab.model.robot_state().pose[0]
    assert on["travel_s"] - off["travel_s"] == pytest.approx(inside * (1 / 0.1 - 1 / 0.5), rel=0.1)
    assert lab.masks == {}
    for wrong in (0, 101):
        with pytest.raises(ProtocolError, match="value of 1 to 100"):
            lab.do(type="costmap", keepout=[zone | {"speed": wrong}])


async def test_layers_are_switched_and_a_wide_robot_does_not_fit_through_a_door(lab: Lab) -> None:
    lab.do(type="costmap", values={"map": "plan"})
    lab.do(type="goal", x=7.5, y=9.5)  # the kitchen, behind a door of 0.95 m
    assert lab.path["reaches_goal"]
    wide = [[0.5, 0.5], [-0.5, 0.5], [-0.5, -0.5], [0.5, -0.5]]
    lab.do(type="costmap", footprint=wide)
    assert lab.costmap["inscribed_radius"] == pytest.approx(0.51)
    assert lab.path["length"] is None
    assert "inscribed" in lab.path["reason"]
    lab.do(type="costmap", values={"inflation_layer": False})
    assert lab.path["reaches_goal"]  # nothing says how wide it is
    lab.do(type="costmap", values={"static_layer": False})
    assert not (lab.costs.costs == 254).sum() > 2000
    before = lab.costmap
    for refused in ({"footprint": wide[:2]}, {"values": {"inflation_radius": -1.0}}, {"values": {"colour": 1.0}}):
        with pytest.raises(ConfigError):
            lab.do(type="costmap", **refused)
    assert lab.costmap == before


async def test_each_layer_says_why_a_cell_has_its_cost(lab: Lab) -> None:
    lab.do(type="costmap", values={"map": "plan"})
    lab.do(type="cost", x=8.5, y=7.55)
    (answer,) = lab.answers
    assert [one["layer"] for one in answer["layers"]] == ALL[1:-2]
    assert answer["speed"] is None
    assert 0 < answer["layers"][-1]["master"] < 255
    assert "nearest obstacle" in answer["layers"][-1]["sentence"]
    with pytest.raises(ConfigError, match="not in the costmap"):
        lab.do(type="cost", x=-80.0, y=0.0)


async def test_an_answer_comes_without_a_frame_and_a_change_with_one(lab: Lab) -> None:
    lab.do(type="costmap")
    assert lab.has_changed
    for question in ({"type": "cost", "x": 8.5, "y": 7.55}, {"type": "nav2"}):
        lab.do(**question)
        assert lab.answers
        assert not lab.has_changed
    written = lab.answers[0]["text"]
    for change in ({"type": "nav2", "text": written}, {"type": "costmap", "values": {"inflation_radius": 0.9}},
                   {"type": "costmap", "value": False}):  # fmt: skip
        lab.do(**change)
        assert lab.has_changed


async def test_parameters_go_out_as_nav2_yaml_and_come_back(lab: Lab) -> None:
    lab.do(type="costmap", values={"inflation_radius": 0.8, "lookahead_dist": 1.1, "use_astar": True})
    lab.do(type="nav2")
    written = lab.answers[0]["text"]
    values, outline = lab.costmap["values"], lab.costmap["footprint"]
    wide = [[0.3, 0.3], [-0.3, 0.3], [-0.3, -0.3], [0.3, -0.3]]
    lab.do(type="costmap", values={"inflation_radius": 0.3, "lookahead_dist": 0.4, "use_astar": False}, footprint=wide)
    lab.do(type="nav2", text=written)
    assert lab.costmap["values"] == values
    np.testing.assert_allclose(lab.costmap["footprint"], outline)
    for wrong, said in (
        (written.replace("inflation_radius: 0.8", "inflation_radius: -1"), "inflation_radius"),
        (written.replace("lookahead_dist: 1.1", "lookahead_dist: far"), "lookahead_dist"),
        ("[1, 2", "line"),
    ):
        with pytest.raises(MapperError, match=said):
            lab.do(type="nav2", text=wrong)
        assert lab.costmap["values"] == values
    assert Footprint(tuple(map(tuple, outline))).inscribed_radius > 0.19


async def test_a_loaded_yaml_is_parsed_once(lab: Lab, monkeypatch: pytest.MonkeyPatch) -> None:
    lab.do(type="costmap")
    lab.do(type="nav2")
    written, parsed = lab.answers[0]["text"], []

    def counted(text: str) -> object:
        parsed.append(text)
        return untrusted_yaml.load_with_twice(text)

    monkeypatch.setattr(ros_parameters, "load_with_twice", counted)
    lab.do(type="nav2", text=written)
    assert parsed == [written]


async def test_what_a_loaded_yaml_has_besides_is_said_and_downloaded_again(lab: Lab) -> None:
    lab.do(type="costmap")
    lab.do(type="nav2")
    text = lab.answers[0]["text"].replace("obstacle_layer", "laser")
    lab.do(type="nav2", text=text.replace("track_unknown", "update_frequency: 3.5\n      track_unknown"))
    assert lab.notices == ["nav2.kept"]
    followed = text.replace("controller_plugins:", "controller_frequency: 12.0\n    controller_plugins:")
    followed = followed.replace("rotate_to_heading_angular_vel: 1.8", "rotate_to_heading_angular_vel: 0.9")
    lab.do(type="nav2", text=followed.replace("track_unknown", "update_frequency: 3.5\n      track_unknown"))
    lab.do(type="costmap", values={"lookahead_dist": 1.3})
    lab.do(type="nav2")
    path = parse_nav2_path(lab.answers[0]["text"].encode())
    assert (path.pursuit.rotate_to_heading_angular_vel, path.pursuit.lookahead_dist) == (0.9, 1.3)
    assert path.unused == ("controller_server.controller_frequency",)
    found = parse_nav2_costmap(lab.answers[0]["text"].encode())
    assert found.others[("update_frequency",)] == 3.5
    (laser,) = (one for one in found.layers if one.name == "laser")
    assert isinstance(laser.config, ObstacleConfig)
    assert [source.topic for source in laser.config.sources or ()] == ["/scan"]


def resumed(navigation: list[Struct]) -> History:
    """The history of which a page has kept the commands."""
    return History.model_validate_json(History(navigation=navigation).model_dump_json())


async def test_a_story_begins_the_same_costmap_again(lab: Lab) -> None:
    """Its parameters, outline, zones and goal; what is no costmap in a story is refused."""
    corners = [[0.3, 0.2], [-0.3, 0.2], [-0.3, -0.2], [0.3, -0.2]]
    zones = [{"width": 0.4, "erases": False, "points": [[9.0, 7.0], [9.5, 7.0]]}]
    zones.append(zones[0] | {"speed": 30})
    assert lab.model.history() == []
    lab.do(type="costmap", values={"inflation_radius": 0.8}, footprint=corners, keepout=zones)
    lab.do(type="goal", x=BEYOND[0], y=BEYOND[1], drives=True)
    commands = lab.model.history()
    lab.do(type="costmap", value=False)
    assert not lab.costmap["is_on"]
    lab.model.resume(resumed(commands))
    lab.model.draw(TickResult())
    assert (lab.costmap["values"]["inflation_radius"], lab.costmap["footprint"]) == (0.8, corners)
    assert lab.costmap["keepout"] == zones
    assert (lab.path["goal"], lab.path["drives"]) == ([BEYOND[0], BEYOND[1]], True)
    with pytest.raises(ProtocolError, match="A story cannot hold the command 'drive'"):
        lab.model.resume(resumed([DriveCommand(1.0, 0.0)]))


async def test_the_potential_is_written_only_while_it_is_watched(registry: SessionRegistry) -> None:
    session = await new_simulation(registry, "me", "office", 3, playing=False)
    client = session.join()
    client.subscribe(["map", "plan"])
    await obeyed(session, type="costmap", value=True)
    await obeyed(session, type="goal", x=BEYOND[0], y=BEYOND[1])
    layer = next(one for one in session.hub.layers if one.name == "potential")
    assert isinstance(layer, GridLayer)
    assert (layer.is_watched, layer.picture) == (False, None)
    client.subscribe(["map", "potential"])  # nothing else wakes a session that is paused
    await eventually(lambda: layer.picture is not None)
    assert layer.picture is not None
    first = layer.picture.newest
    client.subscribe(["map"])
    await obeyed(session, type="goal", x=7.0, y=7.0)
    await obeyed(session, type="teleport", x=6.0, y=6.0, yaw=0.0)
    assert layer.picture.newest == first
    session.leave(client)
    assert not any(one.is_watched for one in session.hub.layers)


async def test_a_story_holds_what_a_loaded_yaml_has_besides(lab: Lab) -> None:
    """Also of a layer that is off now, and values of the follower that no slider has."""
    lab.do(type="costmap")
    assert [type(one) for one in lab.model.history()] == [CostmapCommand]
    lab.do(type="nav2")
    text = lab.answers[0]["text"].replace("rotate_to_heading_angular_vel: 1.8", "rotate_to_heading_angular_vel: 0.9")
    text = text.replace("track_unknown", "update_frequency: 3.5\n      track_unknown").replace("/scan", "/front")
    lab.do(type="nav2", text=text)
    lab.do(type="costmap", values={"obstacle_layer": False, "inflation_radius": 0.8})
    lab.do(type="goal", x=BEYOND[0], y=BEYOND[1])
    commands = lab.model.history()
    lab.do(type="costmap", value=False)
    lab.model.resume(resumed(commands))
    lab.model.draw(TickResult())
    assert lab.model.history() == commands
    assert (lab.costmap["values"]["obstacle_layer"], lab.costmap["values"]["inflation_radius"]) == (False, 0.8)
    assert lab.path["goal"] == [BEYOND[0], BEYOND[1]]
    lab.do(type="costmap", values={"obstacle_layer": True})
    lab.do(type="nav2")
    found = parse_nav2_costmap(lab.answers[0]["text"].encode())
    assert found.others[("update_frequency",)] == 3.5
    (laser,) = (one.config for one in found.layers if one.name == "obstacle_layer")
    assert isinstance(laser, ObstacleConfig)
    assert [source.topic for source in laser.sources or ()] == ["/front"]
    assert parse_nav2_path(lab.answers[0]["text"].encode()).pursuit.rotate_to_heading_angular_vel == 0.9


LOADED = """
amcl: {ros__parameters: {alpha1: 0.25}}
planner_server: {ros__parameters: {GridBased: {plugin: nav2_smac_planner::SmacPlanner2D, max_iterations: 7}}}
robot/global_costmap:
  global_costmap:
    ros__parameters:
      width: 9
      robot_radius: 0.2
      footprint_padding: 0.03
      track_unknown_space: true
      plugins: [map, sensors, sonar, gradient]
      filters: [zones]
      map: {plugin: "nav2_costmap_2d::StaticLayer", map_topic: /m, footprint_clearing_enabled: true}
      sensors:
        plugin: "nav2_costmap_2d::PluginContainerLayer"
        combination_method: 1
        plugins: [boxes, tables, near]
        boxes:
          plugin: "nav2_costmap_2d::ObstacleLayer"
          observation_sources: front
          front: {topic: /scan, clearing: true, obstacle_max_range: 4.0, raytrace_min_range: 0.2}
        tables: {plugin: "my_pkg::Tables", from: /tables}
        near: {plugin: "nav2_costmap_2d::InflationLayer", inflation_radius: 0.2}
      sonar: {plugin: "nav2_costmap_2d::RangeSensorLayer", topics: [/sonar]}
      gradient: {plugin: "nav2_costmap_2d::InflationLayer", inflation_radius: 5.0, cost_scaling_factor: 2.5}
      zones: {plugin: "nav2_costmap_2d::KeepoutFilter", transform_tolerance: 0.4}
"""


async def test_nothing_of_a_loaded_yaml_is_lost_and_only_what_is_changed_changes(lab: Lab) -> None:
    lab.do(type="costmap")
    lab.do(type="nav2", text=LOADED)
    assert lab.costmap["values"]["inflation_radius"] == 3.0, "the slider ends there"
    lab.do(type="nav2")
    before = yaml.safe_load(lab.answers[0]["text"])
    given = yaml.safe_load(LOADED)
    place = ("robot/global_costmap", "global_costmap", "ros__parameters")

    def of(root: Any) -> dict[str, Any]:
        return functools.reduce(operator.getitem, place, root)

    assert before == given
    # One layer in the container, and the one above, have the slider's value then.
    lab.do(type="costmap", values={"inflation_radius": 0.5, "obstacle_max_range": 3.0})
    lab.do(type="nav2")
    after = yaml.safe_load(lab.answers[0]["text"])
    wanted = of(given)
    wanted["gradient"]["inflation_radius"] = wanted["sensors"]["near"]["inflation_radius"] = 0.5
    wanted["sensors"]["boxes"]["front"] |= {"obstacle_max_range": 3.0, "raytrace_max_range": 3.5}
    assert of(after) == wanted
    assert (after["amcl"], after["planner_server"]) == (given["amcl"], given["planner_server"])
    # A radius of more cells than there can be is refused by its path, and nothing has changed.
    with pytest.raises(MapperError, match=r"global_costmap\.gradient\.inflation_radius: An inflation radius of 19 m"):
        lab.do(type="nav2", text=LOADED.replace("inflation_radius: 5.0", "inflation_radius: 19.0"))
    lab.do(type="nav2")
    assert yaml.safe_load(lab.answers[0]["text"]) == after
    # The same costmap begins again from what a link keeps, and a layer that is off is written as such.
    lab.do(type="costmap", values={"static_layer": False})
    commands = lab.model.history()
    assert [type(one) for one in commands] == [CostmapCommand, Nav2Command]
    lab.do(type="costmap", value=False)
    lab.model.resume(resumed(commands))
    lab.model.draw(TickResult())
    assert lab.model.history() == commands
    lab.do(type="nav2")
    wanted["map"]["enabled"] = False
    assert of(yaml.safe_load(lab.answers[0]["text"])) == wanted


CONTAINER = """
global_costmap:
  global_costmap:
    ros__parameters:
      track_unknown_space: true
      robot_radius: 0.2
      plugins: [inside, gradient]
      inside:
        plugin: "nav2_costmap_2d::PluginContainerLayer"
        plugins: [map, wide]
        map: {plugin: "nav2_costmap_2d::StaticLayer"}
        wide: {plugin: "nav2_costmap_2d::InflationLayer", inflation_radius: 1.2, cost_scaling_factor: 1.0}
      gradient: {plugin: "nav2_costmap_2d::InflationLayer", inflation_radius: 0.4}
"""


async def test_a_loaded_container_is_laid_as_nav2_lays_it(lab: Lab) -> None:
    """Its own inflation is wider than the one above it: as one list the costs would be those of one of them."""
    lab.do(type="costmap", values={"dynamic_layer": False, "terrain_layer": False})
    lab.do(type="nav2", text=CONTAINER)
    lab.do(type="auto", value=True)
    lab.pass_time(1.0)
    grid = lab.model.grid
    whole = build_costmap(grid.geometry, grid.classify(), parse_nav2_costmap(CONTAINER.encode())).costmap
    whole.update()
    np.testing.assert_array_equal(lab.costs.costs, whole.costs)
    lab.do(type="costmap", values={"static_layer": False})
    assert not (lab.costs.costs == 254).any()


async def test_a_layer_and_a_planner_are_added_to_a_file_that_lacks_them(lab: Lab) -> None:
    """Layers that Nav2 knows by their names in its default list alone have their types written beside the new one."""
    smac = "planner_server: {ros__parameters: {GridBased: {plugin: nav2_smac_planner::SmacPlanner2D}}}\n"
    lab.do(type="costmap")
    lab.do(type="nav2", text=smac + "global_costmap: {global_costmap: {ros__parameters: {robot_radius: 0.2}}}\n")
    lab.do(type="costmap", values={"terrain_layer": True, "tolerance": 1.5})
    lab.do(type="nav2")
    found = parse_nav2_costmap(lab.answers[0]["text"].encode())
    assert [one.name for one in found.layers] == ["static_layer", "obstacle_layer", "terrain_layer", "inflation_layer"]
    planners = yaml.safe_load(lab.answers[0]["text"])["planner_server"]["ros__parameters"]
    assert planners["planner_plugins"] == ["GridBased", "NavFn"]
    assert (planners["NavFn"]["tolerance"], planners["GridBased"]) == (
        1.5,
        {"plugin": "nav2_smac_planner::SmacPlanner2D"},
    )
