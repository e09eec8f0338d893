"""Terrain in the lab: its classes of the room with steps, beside what the world is, and the costs that follow."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import AbstractContextManager, nullcontext

import numpy as np
import pytest
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.simulation import WORLDS
from mapper.terrain import Patches, assess, find_ground
from mapper.terrain.textbook import moments_of, plane_of
from mapper.volume.scans.scan_sequence import ScanSequence
from server.parts.costmap.part import CostmapPart
from server.parts.terrain.assessment import TABLE, TerrainParameters, assessed, first_patch
from server.parts.terrain.messages import TerrainCommand
from server.parts.terrain.part import TerrainPart
from server.parts.terrain.patch import first_asked, patch_at
from server.parts.volume.cloud_points import CloudPoints
from server.parts.volume.live_volume import true_ground
from server.parts.wire import command_of
from server.sessions import SessionRegistry
from server.sessions.drawings import Segments
from server.sessions.part import Offers
from server.sessions.tick import TickResult
from server.stream.protocol import ProtocolError
from tests.server.begin import new_simulation
from tests.server.sent import sent, sent_one
from tests.server.sessions.test_lab_volume import LOW_TABLE, Lab

LEVELS = WORLDS["levels"]


class Host:
    """What a terrain asks of the host: it may always continue."""

    def cancellable(self, *, by_newer: bool) -> AbstractContextManager[None]:
        assert not by_newer
        return nullcontext()

    def may_continue(self) -> bool:
        return True


def offers() -> Offers:
    return Offers(Host())  # type: ignore[arg-type]


class Later:
    """A cloud whose points come after the part was made, as those of the lab."""

    truth = None

    def __init__(self, cloud: CloudPoints) -> None:
        self.count = 0
        self.points, self.read = cloud.points, cloud.read


def terrain_of(lab: Lab) -> TerrainPart:
    return next(part for part in lab.model.parts if isinstance(part, TerrainPart))


def message_of(lab: Lab) -> dict[str, object]:
    return next(one for one in sent(lab.model.messages()) if one["type"] == "terrain")


@pytest.fixture
async def lab(registry: SessionRegistry) -> AsyncIterator[Lab]:
    session = await new_simulation(registry, "me", "levels", 3, playing=False)
    async with session.locked():
        yield Lab(session.model)


def surface(n: int = 40_000) -> np.ndarray:
    """Points on what one sees of the room with steps from above."""
    rng = np.random.default_rng(1)
    points = rng.uniform((0.3, 0.3, 0.0), (13.7, 5.8, 0.0), (n, 3))
    for block in LEVELS.blocks:
        low, high = block.outline.min(axis=0), block.outline.max(axis=0)
        inside = ((points[:, :2] >= low) & (points[:, :2] <= high)).all(axis=1)
        a, b, c = block.top
        points[inside, 2] = np.maximum(points[inside, 2], a + points[inside, :2] @ (b, c))
    points[:, 2] += rng.normal(0.0, 0.005, n)
    return points


def test_floor_and_ramp_are_safe_and_the_edges_of_stairs_and_tables_are_not() -> None:
    points = surface()
    found = assessed(points, LEVELS.bounds, TerrainParameters().with_values({"filter": False, "max_slope": 25.0}))
    assert found is not None
    state = {name: patch_at(found, *place).state for name, place in (
        ("floor", (2.0, 5.0)), ("ramp", (11.0, 2.5)), ("stairs", (11.1, 0.8)), ("edge of the table", (3.35, 3.0)),
    )}  # fmt: skip
    assert state == {"floor": "safe", "ramp": "safe", "stairs": "unsafe", "edge of the table": "unsafe"}
    steep = assessed(points, LEVELS.bounds, TerrainParameters().with_values({"filter": False, "max_slope": 10.0}))
    assert steep is not None
    assert patch_at(steep, 11.0, 2.5).state == "unsafe"
    # The costmap has the terrain as its layer, inflated.
    row, col = found.terrain.patches.geometry.world_to_cell((11.1, 0.8))
    assert found.costmap.costs[row, col] == 254
    with pytest.raises(ConfigError, match="outside"):
        patch_at(found, -5.0, 0.0)


def test_a_patch_has_the_moments_and_the_plane_of_its_points() -> None:
    points = surface()
    found = assessed(points, LEVELS.bounds, TerrainParameters().with_values({"filter": False, "level": 1.0}))
    assert found is not None
    patches = found.terrain.patches
    assert patches.size == pytest.approx(0.5)  # four patches of 0.25 m
    row, col = (int(v) for v in patches.geometry.world_to_cell((11.0, 2.5)))
    centre = patches.geometry.cell_to_world((row, col))
    mine = points[(np.abs(points[:, :2] - centre) < 0.25).all(axis=1)]
    expected = moments_of((mine - (*centre, 0.0)).tolist())
    np.testing.assert_allclose(np.reshape(patch_at(found, 11.0, 2.5).moments, (4, 4)), expected, atol=1e-5)
    assert found.terrain.planes[row, col, 5] == pytest.approx(plane_of(expected).slope, abs=1e-6)
    wider = assessed(points, LEVELS.bounds, TerrainParameters().with_values({"filter": False, "reach": 2.0}))
    assert wider is not None
    near = (np.abs(points[:, :2] - wider.terrain.patches.geometry.cell_to_world((4, 8))) < 0.625).all(axis=1)
    about = points[near] - (*wider.terrain.patches.geometry.cell_to_world((4, 8)), 0.0)
    np.testing.assert_allclose(wider.terrain.planes[4, 8, 4], plane_of(moments_of(about.tolist())).roughness, rtol=1e-5)


def test_the_ground_filter_is_judged_by_the_world() -> None:
    points = surface()
    points = points[points[:, 0] < 9.8]  # without the platform, whose stairs make it a part of the ground
    truth = true_ground(LEVELS, points)
    x, y = LOW_TABLE
    on_table = (np.abs(points[:, :2] - (x, y)) < (0.7, 0.4)).all(axis=1)
    assert not truth[on_table].any()
    every = surface()
    assert true_ground(LEVELS, every)[(np.abs(every[:, :2] - (11.0, 2.5)) < 0.3).all(axis=1)].all()
    found = assessed(points, LEVELS.bounds, TerrainParameters(), truth)
    assert found is not None
    assert found.kappa is not None
    assert found.kappa > 95.0
    everything = assessed(points, LEVELS.bounds, TerrainParameters().with_values({"filter": False}), truth)
    assert everything is not None
    assert everything.kappa == pytest.approx(0.0, abs=1e-9)
    assert everything.total_error == pytest.approx(100.0 * (~truth).mean())
    assert assessed(points[:2], LEVELS.bounds, TerrainParameters()) is None


async def test_the_terrain_of_the_3d_map_is_shown_asked_about_and_driven_on(lab: Lab) -> None:
    with pytest.raises(ProtocolError, match="begin the 3D map first"):
        lab.do(type="terrain")
    lab.do(type="map3d")
    lab.look_around()
    lab.do(type="terrain")
    made = terrain_of(lab)._assessment
    assert made is not None
    n = made.terrain.patches.moments[..., 0]
    x, y = made.terrain.patches.geometry.cell_to_world(np.unravel_index(int(np.argmax(n)), n.shape))
    lab.do(type="terrain", x=float(x), y=float(y))
    message = message_of(lab)
    assert message["is_on"]
    assert message["safe"] > 100  # type: ignore[operator]
    assert message["patch"]["state"] == "safe"  # type: ignore[index]
    assert message["patch"]["moments"][0] == n.max()  # type: ignore[index]
    assert message["kappa"] > 50.0  # type: ignore[operator]
    assert {"terrain_costs", "terrain_values"} <= {layer.name for layer in lab.model.layers}
    for shown in ("slope", "roughness", "step", "costmap", "costs"):
        lab.do(type="terrain", values={"shown": shown})
    lab.do(type="costmap", values={"map": "terrain"})
    part = lab.model.find(CostmapPart)
    assert part is not None
    costmap = part.costmap
    assert costmap is not None
    assert costmap.geometry.resolution == pytest.approx(0.25)
    # As a layer: each cell has the cost of the patch around its centre, and says that patch's slope, roughness, step.
    assert "terrain_layer" in {layer.name for layer in lab.model.layers}
    lab.do(type="costmap", values={"map": "belief", "terrain_layer": True, "inflation_layer": False})
    now = terrain_of(lab)._assessment
    assert now is not None
    terrain, own = now.terrain, costmap.geometry
    costs, hit = terrain.costs(), 0
    for at in np.random.default_rng(0).integers(0, own.shape, (300, 2)):
        patch = tuple(int(v) for v in terrain.patches.geometry.world_to_cell(own.cell_to_world(at)))
        inside = terrain.patches.geometry.contains(patch)
        reason = next(one for one in costmap.costmap.why(*map(int, at)) if one.layer == "terrain_layer")
        assert reason.cost == (costs[patch] if inside else 255)
        assert not inside or reason.sentence == terrain.why(*patch)
        hit += int(0 < reason.cost < 255)
    assert hit > 20
    assert (costmap.costs == 254).sum() > (costs == 254).sum()  # of a patch many cells
    result = TickResult()
    lab.model.handle(command_of({"type": "nav2"}), result)
    written = sent_one(result.answers[0][1])["text"]
    assert "gridbloom::TerrainLayer" in written
    lab.do(type="costmap", values={"terrain_layer": False})
    lab.do(type="nav2", text=written)
    assert costmap.parameters.is_on("terrain_layer")
    for row in TABLE:
        with pytest.raises(ConfigError):
            lab.do(type="terrain", values={row.name: "no" if row.kind != "number" else row.high + 1.0})
    lab.do(type="terrain", value=False)
    assert not message_of(lab)["is_on"]
    assert "terrain_layer" not in {layer.name for layer in lab.model.layers}
    lab.do(type="terrain")
    lab.do(type="map3d", value=False)
    lab.pass_time(0.1)
    assert not message_of(lab)["is_on"]


def test_a_cloud_begins_with_patches_of_ten_points_and_costs_of_the_library() -> None:
    points = (surface() * (10.0, 10.0, 1.0)).astype(np.float32)
    none = np.full((1, 3), np.nan)
    scans = ScanSequence("pcd", points, np.array([0, len(points)]), none, np.zeros(1, np.int64), np.zeros(3))
    low, high = points.min(axis=0).astype(np.float64), points.max(axis=0).astype(np.float64)
    source = CloudPoints(scans, low, high)
    view = TerrainPart(offers(), source)
    row = view.tables["terrain"][1]
    assert row.name == "patch"
    assert row.initial == first_patch(points[:, :2]) == 1.5
    result = TickResult()
    view.handle(TerrainCommand(values={"patch": 5.0}), result)
    view.changed(result)
    message = sent_one(result.slots["terrain"])
    assert message["points"] == len(points)
    assert message["kappa"] is None
    ground = points[find_ground(points).is_ground]
    expected = assess(Patches(np.zeros((11, 27, 10)), 5.0, np.array([low[0], low[1], 0.0])).with_points(ground))
    assert message["safe"] == pytest.approx(expected.counts()["safe"], abs=0.1 * expected.counts()["safe"])
    nothing = TerrainPart(offers(), CloudPoints(None, low, high))
    with pytest.raises(ProtocolError, match="no points"):
        nothing.handle(TerrainCommand(), TickResult())
    view.handle(TerrainCommand(values={"patch": 0.1}), result)
    view.changed(result)
    assert "choose larger ones" in str(sent_one(result.slots["terrain"])["problem"])


def share_of_patches_with_ten(places: np.ndarray, side: float) -> float:
    """The share of the points that lie in patches of this side with ten points or more."""
    counts = np.unique(np.floor((places - places.min(axis=0)) / side), axis=0, return_counts=True)[1]
    return float(counts[counts >= 10].sum() / len(places))


def test_the_first_patch_has_ten_points_however_much_of_the_rectangle_is_empty() -> None:
    rng = np.random.default_rng(4)
    everywhere = rng.uniform(0.0, 100.0, (40_000, 2))
    strip = rng.uniform((0.0, 0.0), (100.0, 6.0), (9_000, 2))
    turned = strip @ np.array([[0.6, 0.8], [-0.8, 0.6]])  # most of the rectangle around it is empty
    lidar = np.column_stack([np.cos(a := rng.uniform(0, 6.28, 9_000)), np.sin(a)]) * rng.exponential(12.0, (9_000, 1))
    for places in (everywhere, strip, turned, lidar):
        side = first_patch(places)
        assert share_of_patches_with_ten(places, side) >= 0.75
        assert share_of_patches_with_ten(places, 0.6 * side) < 0.75
    assert first_patch(turned) < first_patch(everywhere)
    assert first_patch(rng.uniform(0.0, 10.0, (90_000, 2))) == 0.2  # dense: what a robot stands on
    assert first_patch(np.zeros((0, 2))) == 0.2
    assert first_patch(np.zeros((5, 2))) > 0.0
    assert 100.0 / first_patch(rng.uniform(0.0, 100.0, (30, 2))) >= 10  # few points: a coarse grid, not one patch
    assert first_patch(rng.uniform(0.0, 0.5, (9000, 2))) < 0.05  # a thing on a table
    wide = first_patch(rng.uniform(0.0, 1e6, (100, 2)))
    assert (1e6 / wide) ** 2 <= 250_000


@pytest.mark.parametrize("side", [1e-4, 1e4, 1e6])
def test_clouds_of_any_extent_have_first_values(side: float) -> None:
    row = next(row for row in TABLE if row.name == "patch")
    points = np.random.default_rng(2).uniform(0.0, side, (2000, 3)).astype(np.float32)
    scans = ScanSequence(
        "pcd", points, np.array([0, 2000]), np.full((1, 3), np.nan), np.zeros(1, np.int64), np.zeros(3)
    )
    source = CloudPoints(scans, points.min(axis=0).astype(np.float64), points.max(axis=0).astype(np.float64))
    assert row.low <= TerrainParameters.for_cloud(source.points()).values["patch"] <= row.high


def test_ransac_leaves_the_stone_out_and_thresholds_are_for_each_property() -> None:
    rng = np.random.default_rng(8)
    floor = np.column_stack([rng.uniform(0.0, 4.0, (4000, 2)), rng.normal(0.0, 0.004, 4000)])
    stone = np.hypot(*(floor[:, :2] - 1.1).T) < 0.25
    floor[stone, 2] += 0.4
    first = {"filter": False, "patch": 1.0, "max_roughness": 0.1, "max_step": 1.0, "fit_distance": 0.03}
    bounds = (0.0, 0.0, 4.0, 4.0)
    plain = assessed(floor, bounds, TerrainParameters().with_values(first))
    robust = assessed(floor, bounds, TerrainParameters().with_values({**first, "fit": "ransac"}))
    assert plain is not None
    assert robust is not None
    assert patch_at(plain, 1.5, 1.5).state == "unsafe"
    assert first_asked(plain) == (1.5, 1.5)
    assert first_asked(robust) is None
    asked = patch_at(robust, 1.5, 1.5)
    assert asked.state == "safe"
    left_out = robust.ground_points[~robust.is_fitted]
    assert (left_out[:, 2] > 0.3).mean() > 0.99
    assert len(left_out) == pytest.approx(stone.sum(), abs=3)
    assert asked.n > asked.moments[0]
    # A patch that is half as steep and half as rough as allowed passes each threshold, and not their sum.
    slope = np.column_stack([rng.uniform(0.0, 4.0, (9000, 2)), rng.normal(0.0, 0.06, 9000)])
    slope[:, 2] += slope[:, 0] * np.tan(np.radians(12.0))
    values = {"filter": False, "patch": 2.0, "max_slope": 20.0, "max_roughness": 0.1, "max_step": 5.0}
    states = []
    for rule in ("weighted_sum", "thresholds"):
        found = assessed(slope, bounds, TerrainParameters().with_values({**values, "rule": rule}))
        assert found is not None
        states.append(patch_at(found, 1.0, 1.0).state)
    assert states == ["unsafe", "safe"]


def test_the_terrain_of_a_file_begins_with_an_unsafe_patch_that_is_explained() -> None:
    rng = np.random.default_rng(5)
    points = np.column_stack([rng.uniform(0.0, 9.0, (9000, 2)), np.zeros(9000)])
    on_ramp = (points[:, 0] > 3.0) & (points[:, 0] < 4.0)
    points[on_ramp, 2] = 2.0 * (points[on_ramp, 0] - 3.0)

    class Points:
        count, truth = 1, None

        def points(self) -> NDArray[np.float64]:
            return points

        def read(self) -> tuple[NDArray[np.float64], tuple[float, float, float, float], None]:
            return points, (0.0, 0.0, 9.0, 9.0), None

    for asks_first in (True, False):
        source, result = Points(), TickResult()
        source.count = int(asks_first)  # those of the lab come later
        view = TerrainPart(offers(), source)
        source.count = 1
        view.handle(TerrainCommand(values={"filter": False, "patch": 1.0}), result)
        view.changed(result)
        patch = view.messages()[0].patch
        assert (patch and (patch.x, patch.y, patch.state)) == ((4.5, 4.5, "unsafe") if asks_first else None)
        view.handle(TerrainCommand(x=8.5, y=8.5), result)
        patch = view.messages()[0].patch
        assert patch is not None
        assert patch.state == "safe"


def test_a_patch_that_is_asked_about_has_its_points_its_neighbours_and_its_children() -> None:
    points = surface()
    values = {"filter": False, "level": 1.0, "fit": "ransac", "fit_distance": 0.02}
    found = assessed(points, LEVELS.bounds, TerrainParameters().with_values(values))
    assert found is not None
    patch = patch_at(found, 11.0, 2.5)
    np.testing.assert_allclose(np.sum(patch.children, axis=0), patch.moments, atol=1e-4)
    assert len(patch.children) == 4
    assert patch.n == len(patch.points) // 3
    # The greatest gap at its edges is the step of the map.
    row, col = (int(v) for v in found.terrain.patches.geometry.world_to_cell((11.0, 2.5)))
    a, b, c = found.terrain.planes[row, col, :3]
    gaps = [abs(a + b * x + c * y - z) for x, y, z in np.reshape(patch.edges, (-1, 3))]
    assert max(gaps) == pytest.approx(found.terrain.steps[row, col], abs=1e-3)
    # Of a window: all points of its patches, and no children.
    wide = assessed(points, LEVELS.bounds, TerrainParameters().with_values({"filter": False, "reach": 1.0}))
    assert wide is not None
    patch = patch_at(wide, 11.0, 2.5)
    at = wide.terrain.patches.geometry.world_to_cell((11.0, 2.5))
    centre = wide.terrain.patches.geometry.cell_to_world(at)
    assert patch.n == (np.abs(points[:, :2] - centre) < 0.375).all(axis=1).sum()
    assert patch.half == pytest.approx(0.375)
    assert patch.children == []
    assert len(patch.points) == 3 * -(-patch.n // -(-patch.n // 400))


def test_points_in_a_vertical_plane_have_a_row_of_patches() -> None:
    rng = np.random.default_rng(2)
    wall = np.column_stack([np.zeros(500), rng.uniform(0.0, 5.0, 500), rng.uniform(0.0, 3.0, 500)])
    found = assessed(wall, (0.0, 0.0, 0.0, 5.0), TerrainParameters())
    assert found is not None
    assert found.terrain.classes.shape == (20, 1)


def test_the_patch_that_is_asked_about_is_marked_in_3d() -> None:
    points = surface()
    low, high = points.min(axis=0), points.max(axis=0)
    none = np.full((1, 3), np.nan)
    scans = ScanSequence(
        "pcd", points.astype(np.float32), np.array([0, len(points)]), none, np.zeros(1, np.int64), np.zeros(3)
    )
    source, result = Later(CloudPoints(scans, low, high)), TickResult()
    view = TerrainPart(offers(), source)
    source.count = 1
    view.handle(TerrainCommand(values={"filter": False}), result)
    view.changed(result)
    assert view.drawings() == []
    view.handle(TerrainCommand(x=11.0, y=2.5), result)
    (mark,) = view.drawings()
    patch = sent_one(result.slots["terrain"])["patch"]
    assert isinstance(mark, Segments)
    corners = {(round(float(x), 3), round(float(y), 3)) for x, y, _ in mark.points.reshape(-1, 3)}
    (cx, cy), half = patch["centre"], float(patch["half"])
    assert corners == {(round(cx + a * half, 3), round(cy + b * half, 3)) for a in (-1, 1) for b in (-1, 1)}
    # The lower lines lie on the ramp, whose plane the world has, and the upper ones above all of its points.
    a, b, c = next(one.top for one in LEVELS.blocks if np.hypot(*one.top[1:]) > 0.05)
    lower, upper = mark.points[:4].reshape(-1, 3), mark.points[4:8].reshape(-1, 3)
    np.testing.assert_allclose(lower[:, 2], a + lower[:, :2] @ (b, c), atol=0.03)
    mine = points[(np.abs(points[:, :2] - (cx, cy)) < half).all(axis=1)]
    assert upper[:, 2].min() > mine[:, 2].max()
    assert view.drawings()[0] is mark  # it is not sent again
    view.handle(TerrainCommand(x=2.0, y=5.0), result)
    assert view.drawings()[0].points[:, :, 0].max() < 3.0  # type: ignore[attr-defined]
    view.handle(TerrainCommand(x=900.0, y=5.0), result)
    assert view.drawings() == []
    view.handle(TerrainCommand(value=False), result)
    assert view.drawings() == []
