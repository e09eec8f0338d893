"""Drawing into a world and erasing from it."""

from __future__ import annotations

import numpy as np
import pytest

from mapper.core.errors import ConfigError, LimitError
from mapper.core.limits import Limits
from mapper.simulation import WORLDS, Drawn, Edits, SensorConfig, Simulation, edited
from mapper.simulation.edits import gone, is_outer, solid_ids
from mapper.simulation.lidar import true_ranges

ROOM = WORLDS["room"]
INNER = next(i for i, solid in enumerate(ROOM.solids) if not is_outer(ROOM, solid))


def test_a_box_is_where_it_was_drawn_and_beams_meet_it() -> None:
    x, y = 4.0, 5.0
    free = true_ranges(ROOM, SensorConfig(n_beams=360), (x, y, 0.0))
    world = edited(ROOM, Edits((Drawn("box", 520, 520, 480, 480),)))
    assert true_ranges(world, SensorConfig(n_beams=360), (x, y, 0.0))[180] == pytest.approx(0.8)
    assert free[180] > 0.9
    assert not world.is_free((5.0, 5.0))
    assert ROOM.is_free((5.0, 5.0))  # a world itself never changes


def test_a_wall_is_as_thick_as_walls_are() -> None:
    world = edited(ROOM, Edits((Drawn("wall", 400, 450, 400, 550),)))
    assert true_ranges(world, SensorConfig(n_beams=360), (5.0, 5.0, np.pi))[180] == pytest.approx(1.0 - 0.06)
    assert world.clearance((4.0, 5.0)) == pytest.approx(-0.06)


def test_ids_identify_solids() -> None:
    edits = Edits((Drawn("box", 480, 480, 520, 520), Drawn("wall", 400, 450, 400, 550)), frozenset([INNER]))
    world = edited(ROOM, edits)
    ids = solid_ids(ROOM, edits)
    assert len(ids) == len(world.solids)
    for i, solid in zip(ids, world.solids, strict=True):
        expected = ROOM.solids[i] if i >= 0 else edits.added[-1 - i].polygon()
        np.testing.assert_allclose(np.sort(solid, axis=0), np.sort(expected, axis=0))
    assert INNER not in ids
    (missing,) = gone(ROOM, world)
    np.testing.assert_array_equal(missing, ROOM.solids[INNER])
    assert len(gone(world, ROOM)) == 2


def test_no_edits_are_the_world_itself() -> None:
    assert edited(ROOM, Edits()) is ROOM


def test_edits_survive_as_plain_lists() -> None:
    edits = Edits((Drawn("box", 1, 2, 300, 400), Drawn("wall", -5, 6, 70, 80)), frozenset([9, 4]))
    assert Edits.of(*edits.as_lists()) == edits


BAD = {
    "kind": ([["disc", 0, 0, 100, 100]], [], "edit.kind"),
    "float": ([["box", 0.5, 0, 100, 100]], [], "edit.place"),
    "flag": ([["box", True, 0, 100, 100]], [], "edit.place"),
    "far": ([["box", 0, 0, 100, 10**9]], [], "edit.place"),
    "thin": ([["box", 300, 300, 300, 400]], [], "edit.small"),
    "short": ([["wall", 300, 300, 301, 300]], [], "edit.small"),
    "row": ([["box", 1, 2, 3]], [], "edit.added"),
    "none": (None, [], "edit.added"),
    "erased": ([], "4", "edit.erased"),
    "half": ([], [0.5], "edit.erased"),
    "outside": ([["box", 900, 700, 1100, 750]], [], "edit.outside"),
    "unknown": ([], [10_000], "edit.unknown"),
    "outer": ([], [0], "edit.outer"),
}


@pytest.mark.parametrize(("added", "erased", "code"), BAD.values(), ids=BAD)
def test_invalid_edits_are_refused_with_a_sentence(added: object, erased: object, code: str) -> None:
    with pytest.raises(ConfigError) as error:
        edited(ROOM, Edits.of(added, erased))
    assert error.value.code == code
    assert error.value.message.endswith(".")


def test_too_many_are_too_many() -> None:
    many = Edits(tuple(Drawn("box", 400, 400, 410 + i, 410) for i in range(5)))
    with pytest.raises(LimitError):
        edited(ROOM, many, Limits(max_added_solids=4))


def test_the_robot_leaves_a_new_solid_and_continues() -> None:
    simulation = Simulation(ROOM, seed=3)
    simulation.advance(3.0)
    x, y, yaw = simulation.robot.pose
    place = [round(100 * v) for v in (x - 0.3, y - 0.3, x + 0.3, y + 0.3)]
    assert simulation.alter_world(edited(ROOM, Edits((Drawn("box", *place),))))
    assert simulation.world.is_free(simulation.pose[:2], simulation.radius)
    assert simulation.pose[2] == pytest.approx(yaw)
    time = simulation.time
    for scan, pose in simulation.advance(20.0):
        assert simulation.world.clearance(pose[:2]) >= simulation.radius - 1e-9
        assert np.isfinite(scan.ranges).any()
    assert simulation.time == pytest.approx(time + 20.0)
    assert not simulation.alter_world(ROOM)
    with pytest.raises(ConfigError, match="bounds"):
        simulation.alter_world(WORLDS["office"])
