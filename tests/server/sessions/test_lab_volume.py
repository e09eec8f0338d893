"""The lab's 3D map: filled while the robot drives, with what the flat map lacks, and within its limits."""

from __future__ import annotations

import io
import math
from collections.abc import AsyncIterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pyoctomap
import pytest
import trimesh
from PIL import Image

from mapper.core.errors import ConfigError
from mapper.core.limits import Limits
from mapper.sensors.scan import LaserScan
from mapper.simulation.sensors_3d import cast
from mapper.volume.mesh.faces import triangles_of
from mapper.volume.mesh.voxel_normals import voxel_normals
from server.parts.costmap.part import CostmapPart
from server.parts.volume import live_volume as lab_volume
from server.parts.volume.look import normal_colors
from server.parts.volume.part import VolumeView
from server.parts.volume.routes import depth_png
from server.parts.wire import command_of
from server.sessions import SessionRegistry
from server.sessions.drawings import Gizmo, GridColumns, Quaternion, Segments, Voxels
from server.sessions.parts import Volumetric
from server.sessions.tick import TickResult
from server.sources.simulation import SimulationModel
from server.stream.commands import TeleportCommand
from server.stream.protocol import fields_of
from tests.mapper.volume.voxel_values import log_odds_at
from tests.server.begin import new_simulation
from tests.server.sent import sent

UPRIGHT: Quaternion = (1.0, 0.0, 0.0, 0.0)
LOW_TABLE = (4.0, 3.0)
AROUND = ((2.6, 3.0, 0.0), (4.0, 1.6, 1.57), (5.6, 3.0, 3.14), (4.0, 4.6, -1.57))


class Lab:
    """A simulation's model without its host's clock."""

    def __init__(self, model: SimulationModel) -> None:
        self.model = model
        self.notices: list[str] = []

    def do(self, **command: Any) -> TickResult:
        result = TickResult()
        self.model.handle(command_of(command), result)
        return self._end(result)

    def pass_time(self, seconds: float) -> None:
        for _ in range(round(10 * seconds)):
            result = TickResult()
            self.model.advance(0.1, result)
            self._end(result)

    def catch_up(self) -> None:
        while self.model.is_catching_up:
            self._end(TickResult())

    def _end(self, result: TickResult) -> TickResult:
        self.model.draw(result)
        self.notices += [notice.message for notice in result.notices]
        return result

    def look_around(self) -> None:
        """Stand at four places around the low table."""
        self.do(type="auto", value=False)
        for x, y, yaw in AROUND:
            self.do(type="teleport", x=x, y=y, yaw=yaw)
            self.pass_time(0.5)

    @property
    def message(self) -> dict[str, Any]:
        return next(one for one in sent(self.model.messages()) if one["type"] == "map3d")

    @property
    def view(self) -> VolumeView:
        view = self.model.find(VolumeView)
        assert view is not None
        return view

    @property
    def map(self) -> lab_volume.LabVolume:
        made = self.view._map
        assert made is not None
        return made

    def states(self) -> np.ndarray[Any, np.dtype[np.uint8]]:
        assert self.view.projection is not None
        return lab_volume.only_in_3d(self.view.projection, self.model.grid)[0]

    def state_at(self, x: float, y: float) -> int:
        projection = self.view.projection
        assert projection is not None
        row, col = projection.geometry.world_to_cell((x, y))
        return int(self.states()[row, col])


@pytest.fixture
async def lab(registry: SessionRegistry) -> AsyncIterator[Lab]:
    session = await new_simulation(registry, "me", "levels", 3, playing=False)
    async with session.locked():
        yield Lab(session.model)


async def test_the_low_table_is_in_the_3d_map_and_not_in_the_flat_one(lab: Lab) -> None:
    assert not lab.message["is_on"]
    assert [layer.name for layer in lab.model.layers] == ["map"]
    before = lab.model.footprint.cells
    lab.do(type="map3d")
    lab.look_around()
    message = lab.message
    assert message["is_on"]
    assert message["scans"] == len(lab.map.scans) >= 8
    x, y = LOW_TABLE
    row, col = lab.model.grid.geometry.world_to_cell(LOW_TABLE)
    assert lab.model.grid.log_odds[row, col] < 0.0  # free in the belief
    assert log_odds_at(lab.map.volume, [(x, y, 0.24)])[0] > 0.0  # occupied in space
    assert lab.state_at(x, y) == 2
    assert lab.state_at(x, 0.15) == 1  # a wall is in both
    assert lab.state_at(x, y + 1.2) == 0  # the floor, which the band leaves out
    assert message["only_in_3d"] == (lab.states() == 2).sum() >= 60
    assert {layer.name for layer in lab.model.layers} == {"map", "only_in_3d"}
    assert lab.model.footprint.cells == before + 512 * lab.map.volume.blocks.count
    # Above the band the table is left out, and the shelf on the wall comes in.
    lab.do(type="map3d", values={"band_low": 1.0, "band_high": 1.3})
    assert lab.state_at(x, y) != 2
    lab.do(type="map3d", value=False)
    assert not lab.message["is_on"]
    assert lab.model.footprint.cells == before


async def test_occupied_voxels_lie_on_surfaces_of_the_world(lab: Lab) -> None:
    lab.do(type="map3d", values={"noise": 0.0})
    lab.look_around()
    keys, _ = lab.map.volume.voxels(0.0)
    centres = (keys[keys[:, 2] >= 32768] - 32768 + 0.5) * 0.1  # the ground is met from above
    some = centres[np.random.default_rng(0).choice(len(centres), 200, replace=False)]
    rays = np.random.default_rng(1).normal(size=(400, 3))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    near = [cast(lab.model.world, centre + np.array([0.0, 0.0, 1e-6]), rays, 1.0).min() for centre in some]
    assert max(near) <= 0.5 * math.sqrt(3.0) * 0.1 + 0.02


async def test_other_voxels_remake_the_map_and_change_its_memory(lab: Lab) -> None:
    lab.do(type="map3d")
    lab.look_around()
    fine, scans = lab.message, len(lab.map.scans)
    lab.do(type="map3d", values={"voxel": 0.4})
    assert lab.model.is_catching_up
    assert lab.model.fraction == pytest.approx(lab.message["scans"] / scans)
    lab.catch_up()
    coarse = lab.message
    assert coarse["scans"] == scans
    assert coarse["dense_bytes"] < fine["dense_bytes"] / 50
    assert 0 < coarse["nodes"] < fine["nodes"] / 8
    assert fine["octree_bytes"] == 5 * fine["nodes"] < fine["dense_bytes"]
    # As if it had been mapped so from the start.
    again = lab_volume.LabVolume(lab.model.world, 3, lab.map.parameters)
    again.scans = lab.map.scans
    while again.is_behind:
        again.catch_up(Limits())
    np.testing.assert_array_equal(again.volume.values, lab.map.volume.values)


async def test_beams_without_a_return_stay_free_when_the_range_becomes_longer(lab: Lab) -> None:
    lab.do(type="map3d", values={"reach": 2.0})
    lab.do(type="auto", value=False)
    lab.do(type="teleport", x=4.0, y=1.6, yaw=0.0)
    lab.pass_time(0.5)
    assert any(np.isinf(scan.ranges).sum() > 1000 for scan in lab.map.scans)
    before = {tuple(key) for key in lab.map.volume.voxels(0.0)[0].tolist()}
    lab.do(type="map3d", values={"reach": 8.0, "rate": 0.5})
    scans = [scan for scan in lab.map.scans if scan.sensor.reach == 2.0]
    lab.map.scans[:] = scans
    lab.map.begin_map()
    while lab.map.is_behind:
        lab.map.catch_up(Limits())
    after = {tuple(key) for key in lab.map.volume.voxels(0.0)[0].tolist()}
    assert len(after ^ before) < 0.1 * len(before)  # fewer beams pass


async def test_the_costmap_can_stand_on_the_map_from_above(lab: Lab) -> None:
    lab.do(type="map3d")
    lab.look_around()
    lab.do(type="costmap", values={"map": "belief"})
    part = lab.model.find(CostmapPart)
    assert part is not None
    costmap = part.costmap
    assert costmap is not None

    def cost() -> int:
        row, col = costmap.geometry.world_to_cell(LOW_TABLE)
        return int(costmap.costs[row, col])

    assert cost() == 0
    lab.do(type="costmap", values={"map": "map_3d"})
    assert costmap.geometry.resolution == pytest.approx(0.1)
    assert cost() == 254
    lab.do(type="map3d", values={"voxel": 0.2})
    lab.catch_up()
    assert costmap.geometry.resolution == pytest.approx(0.2)
    assert cost() == 254
    lab.do(type="map3d", value=False)  # without a 3D map it stands on the belief again
    assert costmap.geometry == lab.model.grid.geometry
    assert cost() == 0


async def test_faces_are_made_only_for_a_3d_view(lab: Lab) -> None:
    lab.do(type="map3d")
    lab.look_around()
    assert not lab.view._faces.chunks

    def voxels() -> Voxels:
        drawings = lab.model.drawings()
        assert not any(isinstance(one, GridColumns) for one in drawings)
        return next(one for one in drawings if isinstance(one, Voxels))

    assert not voxels().chunks
    lab.pass_time(0.1)
    first = voxels().chunks
    assert len(first) > 4
    lab.do(type="map3d", values={"cut_high": 0.35})
    low = voxels().chunks
    tops = [int((key[2] * 32 - 32768 + quads[:, 3].max()) * 0.1 * 1000) for key, quads in low.items()]
    assert max(tops) <= 350
    lab.do(type="map3d", values={"cut_high": 1.5})
    lab.do(type="restart")
    assert not voxels().chunks  # of the old map nothing is left


async def test_a_handle_of_the_clip_box_cuts_off_what_lies_outside(lab: Lab) -> None:
    lab.do(type="map3d")
    lab.look_around()
    assert lab.model.on_gizmo_moved("band-low", (0.0, 0.0, 1.0), UPRIGHT) is None
    lab.model.drawings()
    lab.pass_time(0.1)

    def handles() -> dict[str, Gizmo]:
        return {one.name: one for one in lab.model.drawings() if isinstance(one, Gizmo)}

    def drawn() -> np.ndarray[Any, Any]:
        """The least and the greatest coordinates of the voxels with faces."""
        lab.model.drawings()
        lab.pass_time(0.1)
        chunks = next(one for one in lab.model.drawings() if isinstance(one, Voxels)).chunks
        corners = [(triangles_of(quads)[0] + np.array(key) * 32.0 - 32768) * 0.1 for key, quads in chunks.items()]
        return np.array([np.min([one.min(axis=0) for one in corners], axis=0),
                         np.max([one.max(axis=0) for one in corners], axis=0)])  # fmt: skip

    whole = drawn()
    assert not handles()
    lab.do(type="map3d", values={"cut_handles": True})
    _, y0, x1, y1 = lab.model.world.bounds
    assert handles()["cut-x-high"].position == pytest.approx((x1, (y0 + y1) / 2, 0.8))
    moves = ("cut-x-high", (5.0, 9.0, 9.0)), ("cut-y-low", (9.0, 2.0, 9.0)), ("cut-high", (9.0, 9.0, 0.6))
    for name, position in moves:
        command = lab.model.on_gizmo_moved(name, position, UPRIGHT)
        assert command is not None
        lab.do(**fields_of(command))
    assert handles()["cut-x-high"].position == pytest.approx((5.0, (2.0 + y1) / 2, 0.35))
    low, high = drawn()
    np.testing.assert_allclose(low, [whole[0, 0], 2.0, whole[0, 2]], atol=1e-6)
    np.testing.assert_allclose(high, [5.0, whole[1, 1], 0.6], atol=1e-6)
    files = lab.model.find(Volumetric)
    assert files is not None
    saved = trimesh.load(io.BytesIO(files.selection_bytes()), file_type="ply")
    assert isinstance(saved, trimesh.PointCloud)
    assert saved.vertices[:, 0].max() < 5.0
    assert saved.vertices[:, 1].min() > 2.0
    lab.do(type="world", name="office")  # another one is drawn from wall to wall
    _, y0, x1, y1 = lab.model.world.bounds
    assert handles()["cut-x-high"].position == pytest.approx((x1, (y0 + y1) / 2, 0.35))


async def test_voxels_have_the_colours_of_their_normals(lab: Lab) -> None:
    lab.do(type="map3d")
    lab.look_around()

    def voxels() -> Voxels:
        return next(one for one in lab.model.drawings() if isinstance(one, Voxels))

    voxels()
    lab.pass_time(0.1)
    heights = voxels()
    lab.do(type="map3d", values={"colour": "normal"})
    lab.pass_time(0.1)
    found = voxels()
    assert found.chunks.keys() == heights.chunks.keys()
    for key, quads in found.chunks.items():
        numbers, normals = voxel_normals(lab.map.volume, key)
        wanted = np.zeros((32**3, 3), dtype=np.int64)
        wanted[numbers] = normal_colors(np.round(127.0 * normals).astype(np.int8))
        x, y, z = quads[:, 1:4].astype(np.int64).T
        away = found.palette[quads[:, 6] - 1] - wanted[(z * 32 + y) * 32 + x]
        assert np.abs(away).max() < 25  # directions are told apart in steps
    lab.do(type="map3d", values={"colour": "height"})
    lab.pass_time(0.1)
    assert voxels().palette is heights.palette


async def test_a_click_is_answered_by_the_scans_that_made_the_voxel_so(lab: Lab) -> None:
    assert lab.model.on_scene_ray((4.0, 3.0, 2.0), (0.0, 0.0, -1.0)) == TeleportCommand(4.0, 3.0)
    with pytest.raises(ConfigError, match="no 3D map"):
        lab.do(type="voxel", x=4.0, y=3.0, z=0.24)
    lab.do(type="map3d", values={"half_life": 20.0})
    lab.look_around()
    # Straight down on the board of the low table, from below its drawn surroundings' ceiling.
    lab.do(type="map3d", values={"click": "places_the_robot"})
    assert lab.model.on_scene_ray((4.0, 3.0, 2.0), (0.0, 0.0, -1.0)) == TeleportCommand(4.0, 3.0)
    assert "place the robot" in (lab.model.controls().hint or "")
    lab.do(type="map3d", values={"click": "asks_a_voxel"})
    assert "ask about it" in (lab.model.controls().hint or "")
    command = lab.model.on_scene_ray((4.02, 3.02, 1.0), (0.0, 0.0, -1.0))
    assert command is not None
    why = next(one for one in sent(lab.do(**fields_of(command)).slots.values()) if one["type"] == "voxel")
    value = float(log_odds_at(lab.map.volume, [why["centre"]])[0])
    assert why["state"] == "occupied"
    assert 0.2 <= why["centre"][2] <= 0.4
    assert why["log_odds"] == pytest.approx(value)
    assert why["hits"] >= 1
    # What it had after its last update has decayed by the closed form since.
    last = why["updates"][-1]
    elapsed = lab.map.scans[-1].stamp_s - lab.map.scans[last["scan"] - 1].stamp_s
    assert value == pytest.approx(last["after"] * 0.5 ** (elapsed / 20.0), rel=1e-5)
    assert any(isinstance(one, Segments) and one.name == "hits" for one in lab.model.drawings())
    lab.do(type="map3d", values={"voxel": 0.2})  # another map: the answer is over
    assert not any(isinstance(one, Segments) for one in lab.model.drawings())


async def test_what_is_not_seen_again_is_forgotten(lab: Lab) -> None:
    lab.do(type="map3d", values={"half_life": 2.0})
    lab.look_around()
    before = lab.map.volume.n_known
    lab.do(type="teleport", x=1.0, y=1.0, yaw=-2.4)
    lab.do(type="map3d", values={"sensor": "depth_camera"})  # which sees one corner only
    lab.pass_time(12.0)
    assert 0 < lab.map.volume.n_known < before / 3
    lab.do(type="map3d", values={"half_life": 0.0})
    lab.catch_up()
    assert lab.map.volume.n_known >= before


async def test_its_depth_camera_sees_what_the_flat_lidar_measures_ahead(registry: SessionRegistry) -> None:
    session = await new_simulation(registry, "me", "office", 3, playing=False)  # whose walls are higher than the camera
    async with session.locked():
        lab = Lab(session.model)
        lab.do(type="auto", value=False)
        assert lab.view.newest_depths() is None
        lab.do(type="map3d", values={"sensor": "depth_camera", "noise": 0.0, "tilt": 0.0, "reach": 20.0})
        x, y, _ = lab.model.robot_state().pose
        for yaw in (3.14, -1.57):  # towards walls
            lab.do(type="teleport", x=x, y=y, yaw=yaw)
            lab.pass_time(0.5)
            found, scan = lab.view.newest_depths(), lab.model.robot_state().scan
            assert found is not None
            assert isinstance(scan, LaserScan)
            depths, reach = found
            assert (depths.shape, reach) == ((72, 96), 20.0)
            bearings = scan.angle_min + scan.angle_increment * np.arange(len(scan.ranges))
            ahead = scan.ranges[np.abs(bearings) < 0.02].mean()
            assert depths[35:37, 47:49].mean() == pytest.approx(ahead, abs=0.08)
    grey = np.asarray(Image.open(io.BytesIO(depth_png(depths, reach)))).ravel()
    order = np.argsort(depths.ravel())
    assert ((grey == 0) == (depths.ravel() == 0.0)).all()
    assert (np.diff(grey[order][(depths.ravel() > 0.0)[order]].astype(int)) <= 0).all()


async def test_other_programs_read_its_files(lab: Lab, tmp_path: Path) -> None:
    lab.do(type="map3d")
    lab.look_around()
    files = lab.model.find(Volumetric)
    assert files is not None
    path = tmp_path / "lab.ot"
    path.write_bytes(files.octree_bytes(".ot"))
    tree = pyoctomap.OcTree(0.1).read(str(path))
    node = tree.search([4.02, 3.02, 0.24])
    assert node.getLogOdds() == pytest.approx(float(log_odds_at(lab.map.volume, [(4.02, 3.02, 0.24)])[0]))
    mesh = trimesh.load_mesh(io.BytesIO(files.mesh_bytes(".glb")), file_type="glb", process=False)
    keys, _ = lab.map.volume.voxels(0.0)
    low, high = (keys.min(axis=0) - 32768) * 0.1, (keys.max(axis=0) - 32767) * 0.1
    turned = np.array([[low[0], low[2], -high[1]], [high[0], high[2], -low[1]]])  # y is up in glTF
    np.testing.assert_allclose(mesh.bounds, turned, atol=1e-4)
    above = files.above
    assert above is not None
    row, col = above.geometry.world_to_cell(LOW_TABLE)
    assert above.log_odds[row, col] > 0.0
    lab.do(type="map3d", value=False)
    with pytest.raises(ConfigError, match="no 3D map"):
        files.octree_bytes(".bt")


async def test_it_stays_within_its_limits_and_says_so(lab: Lab, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(lab_volume, "MOST_BLOCKS", 40)
    lab.do(type="map3d")
    lab.look_around()
    assert lab.map.volume.blocks.count <= 40
    assert "choose a coarser resolution" in lab.message["problem"]
    assert lab.notices == [lab.message["problem"]]
    taken = lab.message["taken"]
    lab.pass_time(1.0)
    assert lab.message["taken"] == taken  # it measures no more
    monkeypatch.setattr(lab_volume, "MOST_BLOCKS", 30_000)
    lab.do(type="map3d", values={"voxel": 0.3})
    lab.catch_up()
    assert lab.message["problem"] is None
    # A recording that becomes too long loses every second scan, and keeps the newest.
    monkeypatch.setattr(lab_volume, "MOST_READINGS", 8 * 16 * 360)
    lab.pass_time(3.0)
    newest = lab.map.scans[-1].stamp_s
    assert len(lab.map.scans) <= 8
    assert newest == pytest.approx(lab.model._mapper.simulation.time, abs=0.3)
    assert not lab.model.is_catching_up
    for values in ({"voxel": 0.01}, {"lens": 1.0}, {"band_low": 1.0, "band_high": 0.5}, {"rings": 7.5}):
        with pytest.raises(ConfigError):
            lab.do(type="map3d", values=values)
    small = replace(Limits(), max_cells=512 * 3)
    assert lab.map.catch_up(small) == []
