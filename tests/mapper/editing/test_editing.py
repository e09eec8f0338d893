"""Edits of a map against cells found one by one, undone and done again, and saved, read and carried out again."""

import itertools
import json
import math
import re
from collections.abc import Mapping
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from scipy import ndimage

from mapper.core.errors import ConfigError, LimitError, ReadError, WorkCancelledError
from mapper.editing import EditedMap, areas, edited_map, operation_dict, parse_operation
from mapper.editing.edited_map import without_specks
from mapper.editing.files import apply_edits, edits_text, parse_edits, save_edited
from mapper.editing.operations import Paint
from mapper.grid import GridGeometry
from mapper.io.maps import load_map

STROKE: dict[str, Any] = {
    "op": "paint",
    "state": "occupied",
    "width": 0.35,
    "points": [[0.5, 0.5], [2.0, 1.1], [2.0, 2.0]],
}
AREA: dict[str, Any] = {"op": "fill", "state": "unknown", "polygon": [[1.0, 0.2], [3.1, 0.4], [1.4, 2.2]]}
ZONE = {"op": "keepout", "polygon": [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], "value": 80}
SLOW = {"op": "speed", "polygon": [[1.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0]], "value": 30}
TURN = {"op": "rotate", "angle": 0.3}
CUT = {"op": "crop", "corners": [[0.32, 0.4], [2.0, 1.99]]}
MOVE = {"op": "origin", "x": 1.0, "y": 0.5, "yaw": 0.5}


def made(yaw: float = 0.0) -> EditedMap:
    geometry = GridGeometry(0.1, 30, 40, (0.0, -0.3, yaw))
    values = np.random.default_rng(1).choice(np.array([0, 0, 0, -1, 100, 40], np.int8), geometry.shape)
    return EditedMap(geometry, values)


def after(edited: EditedMap, *given: Mapping[str, object]) -> EditedMap:
    for one in given:
        edited.apply(parse_operation(one))
    return edited


def distance(p: np.ndarray, a: np.ndarray, b: np.ndarray) -> float:
    share = np.clip(np.dot(p - a, b - a) / np.dot(b - a, b - a), 0.0, 1.0)
    return float(np.linalg.norm(p - a - share * (b - a)))


@pytest.mark.parametrize("yaw", [0.0, 0.7])
def test_a_stroke_covers_the_cells_near_its_line(yaw: float) -> None:
    before, edited = made(yaw), after(made(yaw), STROKE)
    points = np.array(STROKE["points"])
    for row, col in np.ndindex(*edited.geometry.shape):
        centre = edited.geometry.cell_to_world((row, col))
        near = min(distance(centre, a, b) for a, b in pairwise(points))
        if abs(near - 0.175) > 1e-9 and not (edited.geometry.world_to_cell(points) == (row, col)).all(axis=1).any():
            assert edited.values[row, col] == (100 if near < 0.175 else before.values[row, col])
    cells = edited.geometry.world_to_cell(points)
    for row, col in cells[edited.geometry.contains(cells)]:
        assert edited.values[row, col] == 100


def test_an_area_and_a_zone_cover_the_cells_inside() -> None:
    """The triangle by the signs of its edges; the square of 10 × 10 cells by its corners."""
    before, edited = made(), after(made(), AREA, ZONE, SLOW)
    a, b, c = (np.array(p) for p in AREA["polygon"])
    for row, col in np.ndindex(*edited.geometry.shape):
        p = edited.geometry.cell_to_world((row, col))
        turns = [float(np.cross(np.append(e - s, 0), np.append(p - s, 0))[2]) for s, e in ((a, b), (b, c), (c, a))]
        if min(abs(turn) for turn in turns) > 1e-9:
            assert edited.values[row, col] == (-1 if min(turns) > 0 else before.values[row, col])
    expected = np.zeros(edited.geometry.shape, np.int8)
    expected[3:13, :10] = 80
    np.testing.assert_array_equal(edited.keepout, expected)
    expected[...] = 0
    expected[3:13, 10:20] = 30
    np.testing.assert_array_equal(edited.speed, expected)
    after(edited, SLOW | {"value": 0})
    assert not edited.speed.any()
    assert edited.keepout.any()


def test_specks_go_and_walls_stay() -> None:
    values = np.zeros((8, 9), np.int8)
    values[0, :] = 100  # a wall of 9
    values[3, 3] = values[4, 4] = 100  # two that touch by a corner
    values[6, 7] = 100
    values[7, 0] = -1
    edited = EditedMap(GridGeometry(0.1, 8, 9), values)
    after(edited, {"op": "despeckle", "cells": 1})
    assert (edited.values[3, 3], edited.values[4, 4], edited.values[6, 7]) == (100, 100, 0)
    after(edited, {"op": "despeckle", "cells": 2})
    assert (edited.values == 100).sum() == 9
    assert edited.values[7, 0] == -1


def test_four_quarter_turns_are_none() -> None:
    edited = made()
    one = after(made(), {"op": "rotate", "angle": math.pi / 2})
    np.testing.assert_array_equal(one.values, np.rot90(made().values, -1)[:, :], err_msg="rows count upwards")
    assert one.geometry.shape == (40, 30)
    after(edited, *[{"op": "rotate", "angle": math.pi / 2}] * 4)
    np.testing.assert_array_equal(edited.values, made().values)
    assert edited.geometry.origin == pytest.approx(made().geometry.origin, abs=1e-9)


def test_a_turned_map_has_each_value_where_it_was_turned_to() -> None:
    before, edited = after(made(), SLOW), after(made(), ZONE, SLOW, TURN)
    assert edited.geometry.origin[2] == 0.0
    back = np.array([[math.cos(0.3), math.sin(0.3)], [-math.sin(0.3), math.cos(0.3)]])
    for row, col in np.ndindex(*edited.geometry.shape):
        old = before.geometry.world_to_cell(back @ edited.geometry.cell_to_world((row, col)))
        inside = before.geometry.contains(old)
        assert edited.values[row, col] == (before.values[tuple(old)] if inside else -1)
        assert edited.speed[row, col] == (before.speed[tuple(old)] if inside else 0)


def test_a_crop_and_a_moved_origin_leave_each_cell_its_place() -> None:
    before, edited = after(made(), SLOW), after(made(), SLOW, CUT)
    assert edited.geometry.shape == (16, 17), "rows of -0.3 m up: 0.4 … 1.99 is 7 … 23, columns 3 … 20"
    np.testing.assert_array_equal(edited.values, before.values[7:23, 3:20])
    np.testing.assert_array_equal(edited.speed, before.speed[7:23, 3:20])
    assert edited.geometry.origin == pytest.approx((0.3, 0.4, 0.0))
    after(edited, MOVE)
    np.testing.assert_array_equal(edited.values, before.values[7:23, 3:20])
    x, y, yaw = edited.geometry.origin
    assert (x, y) == pytest.approx(
        (-0.7 * math.cos(0.5) - 0.1 * math.sin(0.5), 0.7 * math.sin(0.5) - 0.1 * math.cos(0.5))
    )
    assert yaw == pytest.approx(-0.5)


def test_undo_and_redo_go_through_the_same_states() -> None:
    edited = made()
    states = [(edited.values, edited.geometry)]
    strokes = [STROKE | {"points": [[0.1 * k, 0.05 * k]]} for k in range(24)]
    for one in [STROKE, *strokes, ZONE, TURN, CUT, MOVE]:
        after(edited, one)
        states.append((edited.values, edited.geometry))
    for values, geometry in reversed(states[:-1]):
        assert edited.undo()
        np.testing.assert_array_equal(edited.values, values)
        assert edited.geometry == geometry
    assert not edited.undo()
    for values, geometry in states[1:]:
        assert edited.redo()
        np.testing.assert_array_equal(edited.values, values)
        assert edited.geometry == geometry
    assert not edited.redo()
    edited.undo()
    after(edited, AREA)
    assert not edited.can_redo
    assert len(edited.operations) == len(states) - 1


def test_edits_are_saved_and_carried_out_again(tmp_path: Path) -> None:
    edited = after(made(), STROKE, AREA, ZONE, TURN, CUT, MOVE)
    paths = save_edited(edited, tmp_path / "new" / "room", "old.yaml", "odom")
    assert [path.name for path in paths] == [
        "room.pgm", "room.yaml", "room_keepout.pgm", "room_keepout.yaml", "room.edits.json",
    ]  # fmt: skip
    loaded = load_map(tmp_path / "new" / "room.yaml")
    np.testing.assert_array_equal(loaded.values, edited.values)
    assert (loaded.grid.geometry.origin, loaded.description.frame) == (edited.geometry.origin, "odom")
    mask = load_map(tmp_path / "new" / "room_keepout.yaml")
    np.testing.assert_array_equal(mask.values, edited.keepout)
    again = made()
    apply_edits(again, *parse_edits((tmp_path / "new" / "room.edits.json").read_bytes()))
    np.testing.assert_array_equal(again.values, edited.values)
    assert again.geometry == edited.geometry
    assert [operation_dict(one) for one in again.operations] == [operation_dict(one) for one in edited.operations]


def test_a_map_of_three_states_is_saved_as_map_saver_does(tmp_path: Path) -> None:
    values = np.array([[0, 100, -1]], np.int8)
    save_edited(EditedMap(GridGeometry(0.1, 1, 3), values), tmp_path / "three")
    with Image.open(tmp_path / "three.pgm") as image:
        assert np.asarray(image).tolist() == [[254, 0, 205]]
    assert "mode: trinary" in (tmp_path / "three.yaml").read_text()


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"op": "explode"}, "'op' must be one of paint, fill"),
        ([], "'op' must be one of"),
        (STROKE | {"width": -1}, "width must be a number, 0 … 20, not -1"),
        (STROKE | {"width": float("nan")}, "width must be a number"),
        (STROKE | {"state": "wall"}, "must be one of free, occupied, unknown, not 'wall'"),
        (STROKE | {"points": []}, "must have 1 to 20000 points"),
        (STROKE | {"points": [[1, 2, 3]]}, r"point 0 must be \[x, y\]"),
        (STROKE | {"points": [[1, float("inf")]]}, "a coordinate of point 0 must be a number"),
        (STROKE | {"colour": 1}, "has no 'colour'"),
        ({"op": "fill", "state": "free"}, "lacks polygon"),
        ({"op": "crop", "corners": [[0, 0], [1, 1], [2, 2]]}, "two corners, not 3"),
        (STROKE | {"points": [[90.0, 90.0]]}, "The stroke is outside the map"),
        ({"op": "crop", "corners": [[50, 50], [51, 51]]}, "contains no cell of the map"),
    ],
)
def test_an_impossible_edit_is_refused_and_nothing_changes(given: Mapping[str, object], said: str) -> None:
    edited = made()
    with pytest.raises(ConfigError, match=said):
        edited.apply(parse_operation(given))
    assert (edited.operations, edited.can_redo) == ((), False)


def test_files_that_are_no_edits_of_this_map() -> None:
    text = edits_text(after(made(), STROKE))
    for data, error, said in (
        (b"[1", ReadError, "not JSON"),
        (b"{}", ReadError, "its 'format' is not"),
        (text.replace('"version": 1', '"version": 9').encode(), ReadError, "version 9, not 1"),
        (text.replace('"occupied"', '"wall"').encode(), ConfigError, "Edit 1: The painted state"),
        (b" " * (17 << 20), LimitError, "16 MiB"),
        (text.replace('"width": 40', '"width": "wide"').encode(), ReadError, "'source'.*int.*width"),
        (re.sub(r'"origin": \[[^]]*\]', '"origin": 5', text).encode(), ReadError, "'source'.*array.*origin"),
    ):
        with pytest.raises(error, match=said):
            parse_edits(data)
    source, operations = parse_edits(text.encode())
    with pytest.raises(ConfigError, match="40 × 30 cells, but this one has 9 × 8"):
        apply_edits(EditedMap(GridGeometry(0.1, 8, 9), np.zeros((8, 9), np.int8)), source, operations)
    moved = EditedMap(GridGeometry(0.1, 30, 40), np.zeros((30, 40), np.int8))
    with pytest.raises(ConfigError, match="another resolution or origin"):
        apply_edits(moved, source, operations)
    assert json.loads(text)["source"]["width"] == 40


def test_a_map_comes_with_a_mask_and_states_are_dropped(monkeypatch: pytest.MonkeyPatch) -> None:
    """Undone one by one with few kept states, it goes through the same values as before."""
    mask = np.zeros((30, 40), np.int8)
    mask[3, 4] = 50
    monkeypatch.setattr("mapper.editing.edited_map.MOST_KEPT_CELLS", 9 * 1200)
    edited = EditedMap(made().geometry, made().values, mask)
    states = [edited.values]
    for k in range(70):
        after(edited, STROKE | {"points": [[0.03 * k, 0.05 * (k % 40)]]})
        states.append(edited.values)
        assert edited.cells <= 9 * 1200
    for values in reversed(states[:-1]):
        assert edited.undo()
        np.testing.assert_array_equal(edited.values, values)
    assert (edited.keepout[3, 4], edited.can_redo, edited.n_undone) == (50, True, 70)
    with pytest.raises(ConfigError, match=r"The keepout mask has \(2, 2\) values"):
        EditedMap(made().geometry, made().values, mask[:2, :2])


def test_many_steps_are_undone_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    edited = after(made(), *[STROKE] * 45)
    done: list[Paint] = []
    paint = edited_map._APPLY[Paint]

    def counted(state: Any, edit: Paint, check: Any) -> Any:
        done.append(edit)
        return paint(state, edit, check)

    monkeypatch.setitem(edited_map._APPLY, Paint, counted)
    assert edited.undo(44)
    assert (len(edited.operations), edited.n_undone, len(done)) == (1, 44, 1)
    assert edited.undo(5)
    assert not edited.undo()
    assert edited.redo(99)
    assert (len(edited.operations), edited.can_redo, len(done)) == (
        45,
        False,
        6,
    )  # redone from the state that is kept after 40


@pytest.mark.parametrize("edit", [{"op": "rotate", "angle": 0.5}, {"op": "despeckle", "cells": 2}])
def test_steps_after_an_edit_of_the_whole_map_do_not_repeat_it(
    edit: dict[str, Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    kind = type(parse_operation(edit))
    done: list[Any] = []
    apply = edited_map._APPLY[kind]

    def counted(state: Any, operation: Any, check: Any) -> Any:
        done.append(operation)
        return apply(state, operation, check)

    monkeypatch.setitem(edited_map._APPLY, kind, counted)
    edited = after(made(), STROKE, edit)
    whole = edited.values
    after(edited, STROKE | {"points": [[0.5, 0.5]]})
    assert edited.undo()
    np.testing.assert_array_equal(edited.values, whole)
    assert edited.undo(2)
    assert edited.redo(2)
    np.testing.assert_array_equal(edited.values, whole)
    assert len(done) == 1


@pytest.mark.parametrize("seed", range(5))
def test_bands_of_rows_make_the_same_edits_as_the_whole_map(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Lines that cross themselves and leave the map; specks that several bands share."""
    points = np.random.default_rng(seed).uniform((-0.5, -0.8), (4.5, 3.2), (9, 2)).tolist()
    edits = [STROKE | {"points": points}, AREA | {"polygon": points}, ZONE | {"polygon": points}]
    edits += [{"op": "despeckle", "cells": seed + 2}]
    whole = [after(made(0.2), one) for one in edits]
    for cells in (1, 3 * 40):
        monkeypatch.setattr(areas, "BAND_CELLS", cells)
        for one, expected in zip(edits, whole, strict=True):
            edited = after(made(0.2), one)
            np.testing.assert_array_equal(edited.values, expected.values)
            np.testing.assert_array_equal(edited.keepout, expected.keepout)


@pytest.mark.parametrize("share", [0.1, 0.3, 0.5])
def test_specks_across_bands_are_those_of_the_whole_map(share: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """Against the groups that SciPy finds in all rows at once; a comb joins groups in its last row only."""
    values = np.where(np.random.default_rng(2).random((60, 50)) < share, 100, 0).astype(np.int8)
    values[40:59, ::4], values[59, :30] = 100, 100
    groups, _ = ndimage.label(values == 100, structure=np.ones((3, 3)))
    sizes = np.bincount(groups.ravel())
    for band, cells in itertools.product((1, 50, 400, 1 << 18), (1, 7, 30, 10_000)):
        monkeypatch.setattr(areas, "BAND_CELLS", band)
        expected = np.where((groups > 0) & (sizes[groups] <= cells), 0, values)
        np.testing.assert_array_equal(without_specks(values, cells, lambda: None), expected)


@pytest.mark.parametrize("edit", [STROKE, AREA, ZONE, {"op": "despeckle", "cells": 3}, TURN, CUT, MOVE])
def test_an_edit_that_is_cancelled_changes_nothing(edit: Mapping[str, object], monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(areas, "BAND_CELLS", 100)
    left = math.inf

    def may_continue() -> bool:
        nonlocal left
        left -= 1
        return left >= 0

    source = made()
    edited = EditedMap(source.geometry, source.values, None, may_continue)
    after(edited, STROKE, ZONE)
    before = edited.values.copy(), edited.keepout.copy(), edited.geometry, edited.operations
    for left in range(1000):  # noqa: B007 - it is what may_continue counts
        try:
            after(edited, edit)
        except WorkCancelledError as error:
            assert error.code == "edit.cancelled"  # noqa: PT017 - the last one succeeds
            np.testing.assert_array_equal(edited.values, before[0])
            np.testing.assert_array_equal(edited.keepout, before[1])
            assert (edited.geometry, edited.operations) == before[2:]
        else:
            break
    assert len(edited.operations) == 3
    left = 0
    with pytest.raises(WorkCancelledError):
        edited.undo(2)
    assert (len(edited.operations), edited.n_undone) == (3, 0)


def test_a_tall_map_is_turned_in_few_pieces_and_as_whole(monkeypatch: pytest.MonkeyPatch) -> None:
    whole = after(made(), TURN)
    monkeypatch.setattr(edited_map, "_AT_ONCE", 7)
    np.testing.assert_array_equal(after(made(), TURN).values, whole.values)
    monkeypatch.undo()
    calls: list[Any] = []
    world_to_cell = GridGeometry.world_to_cell

    def counted(self: GridGeometry, points: Any) -> Any:
        calls.append(points)
        return world_to_cell(self, points)

    monkeypatch.setattr(GridGeometry, "world_to_cell", counted)
    tall = EditedMap(GridGeometry(0.1, 5000, 1), np.zeros((5000, 1), np.int8))
    after(tall, {"op": "rotate", "angle": 0.0})
    assert len(calls) == 1
