"""The lab's 3D scans as a surface: made of all of them, with its parameters, for a 3D view, asked about, downloaded."""

from __future__ import annotations

import io
from collections.abc import AsyncIterator

import numpy as np
import pytest
import trimesh

from mapper.core.errors import ConfigError
from mapper.simulation.sensors_3d import cast
from mapper.volume import TsdfConfig, TsdfVolume, surface_mesh
from server.parts.volume import live_volume as lab_volume
from server.sessions import SessionRegistry
from server.sessions.drawings import Segments, Surface, Voxels
from server.sessions.parts import Volumetric
from server.stream.protocol import fields_of
from tests.server.begin import new_simulation
from tests.server.sent import sent
from tests.server.sessions.test_lab_volume import LOW_TABLE, Lab


@pytest.fixture
async def lab(registry: SessionRegistry) -> AsyncIterator[Lab]:
    session = await new_simulation(registry, "me", "levels", 3, playing=False)
    async with session.locked():
        yield Lab(session.model)


def surface_of(lab: Lab) -> TsdfVolume:
    made = lab.view._surface
    assert made is not None
    return made.surface.replayed.volume


def fused(lab: Lab, config: TsdfConfig) -> TsdfVolume:
    """Return the surface of all recorded scans, fused without the session."""
    volume = TsdfVolume(config)
    for scan in lab.map.scans:
        image = scan.depth_image()
        if image is None:
            points, origin = scan.ends()
            volume.fuse_points(points[np.isfinite(scan.ranges)], origin)
        else:
            volume.fuse_depth(image.depth, image.camera, image.pose)
    return volume


def drawn(lab: Lab) -> Surface:
    """Return what a 3D view shows once all is meshed."""
    lab.model.drawings()
    lab.pass_time(0.1)
    while lab.view._surface is not None and lab.view._surface.is_unmeshed:
        lab.model.drawings()
        lab.pass_time(0.1)
    return next(one for one in lab.model.drawings() if isinstance(one, Surface))


def triangles(surface: Surface) -> int:
    return sum(len(one.triangles) for one in surface.chunks.values())


async def test_a_lidar_and_a_depth_camera_make_one_surface_near_the_true_one(lab: Lab) -> None:
    lab.do(type="map3d", values={"noise": 0.0, "voxel": 0.05})
    lab.look_around()
    assert not any(one["type"] == "surface" for one in sent(lab.model.messages()))
    cells = lab.model.footprint.cells
    lab.do(type="map3d", values={"kind": "tsdf", "sensor": "depth_camera"})
    lab.look_around()
    lab.catch_up()
    assert {scan.sensor.sensor for scan in lab.map.scans} == {"spinning_lidar", "depth_camera"}
    volume = surface_of(lab)
    wanted = fused(lab, TsdfConfig(resolution=0.05, range_max=8.0))
    np.testing.assert_array_equal(volume.distances, wanted.distances)
    np.testing.assert_array_equal(volume.weights, wanted.weights)
    assert lab.model.footprint.cells >= cells + 2 * 512 * volume.blocks.count
    vertices = surface_mesh(volume).vertices.astype(np.float64)
    some = vertices[np.random.default_rng(0).choice(len(vertices), 300, replace=False)]
    rays = np.random.default_rng(1).normal(size=(400, 3))
    rays /= np.linalg.norm(rays, axis=1, keepdims=True)
    far = [cast(lab.model.world, place + 1e-6, rays, 1.0).min() for place in some]
    assert np.median(far) < 0.02  # much less than a voxel
    assert lab.message["only_in_3d"] > 0  # the octree goes on


async def test_other_parameters_make_the_surface_again(lab: Lab) -> None:
    lab.do(type="map3d", values={"kind": "tsdf", "cut_low": -0.3, "cut_high": 2.4})
    lab.look_around()
    first = drawn(lab)
    assert triangles(first) > 1000
    assert first.label == "Surface"
    assert not any(isinstance(one, Voxels) for one in lab.model.drawings())
    message = next(one for one in sent(lab.model.messages()) if one["type"] == "surface")
    assert (message["triangles"], message["index"]) == (triangles(first), lab.message["taken"])
    for values in ({"truncation": 0.6}, {"max_weight": 2.0}, {"drop_off": True}, {"voxel": 0.2}):
        before = surface_of(lab)
        lab.do(type="map3d", values=values)
        lab.catch_up()
        config = lab.map.parameters.surface
        assert surface_of(lab) is not before
        np.testing.assert_array_equal(surface_of(lab).distances, fused(lab, config).distances)
    assert triangles(drawn(lab)) == len(surface_mesh(surface_of(lab)).triangles)
    with pytest.raises(ConfigError, match="less than two voxels"):
        lab.do(type="map3d", values={"truncation": 0.3})
    assert lab.message["values"]["truncation"] == 0.6
    lab.do(type="map3d", values={"kind": "occupancy", "truncation": 0.3})  # no surface, nothing to refuse
    assert not any(isinstance(one, Surface) for one in lab.model.drawings())
    with pytest.raises(ConfigError, match="less than two voxels"):
        lab.do(type="map3d", values={"kind": "tsdf"})


async def test_triangles_are_made_for_a_view_and_only_changed_chunks_again(lab: Lab) -> None:
    lab.do(type="map3d", values={"kind": "tsdf", "voxel": 0.05, "cut_high": 2.4})
    lab.look_around()
    made = lab.view._surface
    assert made is not None
    assert made.surface.message().chunks == 0
    before = drawn(lab).chunks
    lab.do(type="map3d", values={"sensor": "depth_camera", "reach": 8.0})
    lab.pass_time(0.5)  # it sees a part of the room
    after = drawn(lab).chunks
    same = [key for key, mesh in before.items() if after.get(key) is mesh]
    assert 0 < len(same) < len(after)
    lab.do(type="map3d", values={"cut_high": 0.35})
    assert triangles(drawn(lab)) < sum(len(one.triangles) for one in after.values()) / 2
    lab.do(type="restart")
    assert lab.message["taken"] == 1  # of the old surface nothing is left
    np.testing.assert_array_equal(surface_of(lab).distances, fused(lab, lab.map.parameters.surface).distances)


async def test_a_voxel_of_the_surface_is_asked_about(lab: Lab) -> None:
    lab.do(type="map3d", values={"kind": "tsdf"})
    lab.look_around()
    lab.do(type="map3d", values={"sensor": "depth_camera"})
    lab.look_around()
    lab.catch_up()
    command = lab.model.on_scene_ray((LOW_TABLE[0], LOW_TABLE[1], 1.0), (0.0, 0.0, -1.0))
    assert command is not None
    why = next(one for one in sent(lab.do(**fields_of(command)).slots.values()) if one["type"] == "surface_voxel")
    assert 0.1 < why["centre"][2] < 0.4
    assert why["total"] == len(why["updates"]) > 0
    volume = surface_of(lab)
    key = np.floor(np.array(why["centre"]) / 0.1).astype(np.int64) + 32768
    slot = volume.blocks.find(np.array([int(key[2] // 8) << 26 | int(key[1] // 8) << 13 | int(key[0] // 8)]))[0]
    i, j, k = key % 8
    assert why["updates"][-1]["after"] == why["distance"] == pytest.approx(float(volume.distances[slot, k, j, i]))
    assert why["weight"] == pytest.approx(float(volume.weights[slot, k, j, i]))
    assert any(isinstance(one, Segments) for one in lab.model.drawings())
    result = lab.do(type="map3d", values={"kind": "occupancy"})  # another map: the answer is over
    assert next(one for one in sent(result.slots.values()) if one["type"] == "surface_voxel")["centre"] is None
    assert not any(isinstance(one, Segments) and one.name == "chosen" for one in lab.model.drawings())


async def test_its_file_is_the_surface_that_is_shown(lab: Lab) -> None:
    lab.do(type="map3d", values={"kind": "tsdf"})
    lab.look_around()
    lab.catch_up()
    files = lab.model.find(Volumetric)
    assert files is not None
    mesh = trimesh.load_mesh(io.BytesIO(files.mesh_bytes(".ply")), file_type="ply", process=False)
    assert len(mesh.faces) == len(surface_mesh(surface_of(lab)).triangles) > 1000
    lab.do(type="map3d", values={"kind": "occupancy"})
    boxes = trimesh.load_mesh(io.BytesIO(files.mesh_bytes(".ply")), file_type="ply", process=False)
    np.testing.assert_allclose(boxes.vertices / 0.1, np.round(boxes.vertices / 0.1), atol=1e-3)


async def test_the_surface_stays_within_its_limits_and_is_that_of_the_scans_that_are_kept(
    lab: Lab, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(lab_volume, "MOST_BLOCKS", 600)
    lab.do(type="map3d", values={"kind": "tsdf", "voxel": 0.05})
    lab.look_around()
    message = next(one for one in sent(lab.model.messages()) if one["type"] == "surface")
    assert "choose a coarser resolution" in message["problem"]
    assert surface_of(lab).blocks.count <= 300
    monkeypatch.setattr(lab_volume, "MOST_BLOCKS", 30_000)
    lab.do(type="map3d", values={"voxel": 0.2})
    lab.catch_up()
    monkeypatch.setattr(lab_volume, "MOST_READINGS", 8 * 16 * 360)
    lab.pass_time(3.0)
    lab.catch_up()
    assert len(lab.map.scans) <= 8
    wanted = fused(lab, lab.map.parameters.surface)
    np.testing.assert_array_equal(surface_of(lab).distances, wanted.distances)
