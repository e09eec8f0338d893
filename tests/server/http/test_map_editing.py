"""The map of a session kept as a map of one's own, edited by commands, and its files over HTTP; costs as files."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from mapper.core.errors import ConfigError, LimitError
from mapper.core.limits import Limits
from mapper.costmap.build import DEFAULT, load_masks
from mapper.editing import EditedMap, parse_operation
from mapper.editing.areas import BAND_CELLS
from mapper.grid import GridGeometry
from mapper.io.costmaps import open_costmaps
from mapper.io.maps import load_map
from server.library.packs.reference_map import ReferenceMap
from server.parts.costmap.zones import painted_filters
from server.parts.editing.messages import MapEditCommand
from server.parts.editing.part import operation_of
from server.parts.wire import command_of
from server.sessions.parts import Costed
from server.sessions.tick import TickResult
from server.sources.map import MapModel
from server.stream.protocol import ProtocolError
from tests.server.sent import sent, sent_one
from tests.server.service import Service, once_read, running, settings_for, until


class Host:
    """Interface of the host that a map uses."""

    def __init__(self, most: int = 1 << 24) -> None:
        self.most, self.yielded = most, 0

    def limits(self) -> Limits:
        return Limits(max_cells=self.most)

    def may_continue(self) -> bool:
        self.yielded += 1
        return True


def model(rows: int = 20, most: int = 1 << 24) -> MapModel:
    given = ReferenceMap("room", GridGeometry(0.1, rows, 30), np.zeros((rows, 30), np.int8), ("A note.",))
    return MapModel(Host(most), given)  # type: ignore[arg-type]


COMMANDS: tuple[dict[str, Any], ...] = (
    {"op": "paint", "state": "occupied", "width": 0.2, "points": [[0.5, 0.5], [1.5, 0.5]]},
    {"op": "fill", "state": "unknown", "points": [[2.0, 0.0], [3.0, 0.0], [3.0, 1.0]]},
    {"op": "keepout", "value": 100, "points": [[0.0, 1.0], [1.0, 1.0], [1.0, 2.0]]},
    {"op": "speed", "value": 40, "points": [[1.0, 1.0], [2.0, 1.0], [2.0, 2.0]]},
    {"op": "despeckle", "value": 2},
    {"op": "rotate", "angle": 0.5},
    {"op": "crop", "points": [[0.0, 0.0], [1.5, 1.5]]},
    {"op": "origin", "points": [[0.5, 0.5]], "angle": 1.0},
)
OPERATIONS: tuple[dict[str, Any], ...] = (
    COMMANDS[0],
    {"op": "fill", "state": "unknown", "polygon": COMMANDS[1]["points"]},
    {"op": "keepout", "value": 100, "polygon": COMMANDS[2]["points"]},
    {"op": "speed", "value": 40, "polygon": COMMANDS[3]["points"]},
    {"op": "despeckle", "cells": 2},
    COMMANDS[5],
    {"op": "crop", "corners": COMMANDS[6]["points"]},
    {"op": "origin", "x": 0.5, "y": 0.5, "yaw": 1.0},
)


def test_commands_are_the_operations_of_the_editor() -> None:
    """Also undone and made again; what the layers show is what the editor has."""
    shown, edited = model(), EditedMap(GridGeometry(0.1, 20, 30), np.zeros((20, 30), np.int8))
    for command, operation in zip(COMMANDS, OPERATIONS, strict=True):
        result = TickResult()
        shown.handle(command_of({"type": "map_edit"} | command), result)
        shown.draw(result)
        edited.apply(parse_operation(operation))
        assert sent_one(result.slots["map_edits"])["last"][-1] == edited.operations[-1].phrase
    map_layer, zones, limits = shown.layers
    for layer in shown.layers:
        layer.publish()
    cells = map_layer.picture.cells  # type: ignore[attr-defined]
    np.testing.assert_array_equal(cells == -128, edited.values == -1)
    np.testing.assert_array_equal(cells > 0, edited.values == 100)
    np.testing.assert_array_equal(zones.picture.cells != -128, edited.keepout > 0)  # type: ignore[attr-defined]
    # A value v of a mask has the picture's value v - 127.
    np.testing.assert_array_equal(limits.picture.cells == 40 - 127, edited.speed == 40)  # type: ignore[attr-defined]
    assert (edited.speed == 40).any()
    assert map_layer.picture.geometry == edited.geometry  # type: ignore[attr-defined]
    result = TickResult()
    shown.handle(command_of({"type": "map_history", "steps": -9}), result)
    assert (sent(shown.messages())[0]["n"], sent(shown.messages())[0]["undone"]) == (0, 8)
    shown.handle(command_of({"type": "map_history", "steps": 3}), result)
    assert (sent(shown.messages())[0]["n"], sent(shown.messages())[0]["notes"]) == (3, ["A note."])


SIDE_M = 100.0
ALL = [[0.0, 0.0], [SIDE_M, 0.0], [SIDE_M, SIDE_M], [0.0, SIDE_M]]


@pytest.mark.parametrize(
    ("command", "passes"),
    [
        ({"type": "map_edit", "op": "paint", "state": "free", "width": 1.0, "points": ALL}, 1),
        ({"type": "map_edit", "op": "fill", "state": "free", "points": ALL}, 1),
        ({"type": "map_edit", "op": "keepout", "value": 100, "points": ALL}, 1),
        ({"type": "map_edit", "op": "despeckle", "value": 20}, 2),
        ({"type": "map_edit", "op": "rotate", "angle": 0.1}, 1),
        ({"type": "map_edit", "op": "crop", "points": [[0.0, 0.0], [SIDE_M, SIDE_M]]}, 0),
        ({"type": "map_history", "steps": -1}, 2),
        ({"type": "map_history", "steps": 2}, 2),
    ],
    ids=lambda value: value.get("op", f"steps {value.get('steps')}") if isinstance(value, dict) else None,
)
def test_a_large_map_is_edited_and_drawn_in_slices(command: dict[str, Any], passes: int) -> None:
    """Other sessions may compute after each band of cells, in each pass over the map and over the two pictures."""
    n = 1024
    given = ReferenceMap("hall", GridGeometry(SIDE_M / n, n, n), np.zeros((n, n), np.int8), ())
    host = Host(1 << 27)
    shown = MapModel(host, given)  # type: ignore[arg-type]
    for _ in range(3):
        shown.handle(command_of({"type": "map_edit", "op": "fill", "state": "unknown", "points": ALL}), TickResult())
    shown.handle(command_of({"type": "map_history", "steps": -2 if command.get("steps") == 2 else 0}), TickResult())
    host.yielded = 0
    result = TickResult()
    shown.handle(command_of(command), result)
    shown.draw(result)
    assert host.yielded >= (passes + 2) * n * n // BAND_CELLS


def test_steps_through_no_edits_change_nothing() -> None:
    shown = model()
    edit = {"type": "map_edit", "op": "keepout", "value": 100, "points": [[0.1, 0.1], [0.5, 0.1], [0.5, 0.5]]}
    undo, stay, redo = ({"type": "map_history", "steps": steps} for steps in (-1, 0, 1))
    for command, is_change in ((undo, False), (edit, True), (redo, False), (undo, True), (stay, False), (redo, True)):
        result = TickResult()
        shown.handle(command_of(command), result)
        shown.draw(result)
        assert (result.changed, "map_edits" in result.slots) == (is_change, is_change), command


def test_what_a_map_refuses() -> None:
    shown = model()
    for command, said in (
        ({"op": "explode"}, "'op' must be one of"),
        ({"op": "paint", "state": "free"}, "lacks width, points"),
        ({"op": "origin", "angle": 1.0}, "lacks x, y"),
        ({"op": "rotate"}, "lacks angle"),
    ):
        with pytest.raises(ConfigError, match=said):
            operation_of(MapEditCommand(**command))
    with pytest.raises(ProtocolError, match="A map session has no command 'seek'"):
        shown.handle(command_of({"type": "seek", "index": 0}), TickResult())
    with pytest.raises(LimitError, match="30 × 20 cells; here one of at most 500 cells"):
        model(most=4000)
    tight = model(most=8 * 700)
    with pytest.raises(LimitError, match="larger than the limit of 700 cells"):
        tight.handle(command_of({"type": "map_edit", "op": "rotate", "angle": 0.785}), TickResult())
    assert sent(tight.messages())[0]["n"] == 0


@pytest.fixture(scope="module")
def service(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Service]:
    with running(settings_for(tmp_path_factory.mktemp("service"))) as service:
        yield service


def test_the_map_of_a_world_is_kept_edited_and_kept_again(service: Service) -> None:
    http = service.http
    world = service.begin(kind="simulation", story={"steps": 40}, playing=False)
    assert http.get(f"/api/sessions/{world}/edited-map/map.pgm").json()["code"] == "session.not_a_map"
    record = http.post(f"/api/sessions/{world}/kept-map", json={"name": "Office"}).json()
    assert once_read(http, record["id"])["map"]["resolution"] == 0.05
    opened = http.post("/api/sessions", json={"kind": "log", "log": record["id"]}).json()
    assert (opened["kind"], opened["title"]) == ("map", "Office")
    address = f"/api/sessions/{opened['id']}/edited-map"
    # The trinary image is that of the world's own map.
    assert http.get(f"{address}/map.pgm").content == http.get(f"/api/sessions/{world}/map.pgm").content
    assert "image: Office_edited.pgm" in http.get(f"{address}/map.yaml").text
    assert http.get(f"{address}/keepout.pgm").json()["message"] == "The map has no keepout zones."
    assert http.get(f"{address}/else").json()["code"] == "map.no_file"

    edit = {"type": "map_edit", "op": "paint", "state": "occupied", "width": 1.0, "points": [[2.0, 2.0]]}
    service.state.sessions.get(opened["id"]).post(command_of(edit))
    until(lambda: http.get(f"{address}/edits.json").status_code == 200)
    edits = http.get(f"{address}/edits.json").json()
    assert (edits["source"]["map"], edits["edits"][0]["width"]) == ("Office", 1.0)
    kept = http.post(address, json={"name": "Better"})
    assert kept.status_code == 201
    read = once_read(http, kept.json()["id"])
    assert (read["name"], read["notes"]) == ("Better", ["Made by 1 edit of 'Office'."])
    assert http.post(address, json={"name": ""}).status_code == 422


def test_costs_and_painted_zones_are_files(service: Service, tmp_path: Path) -> None:
    """Of the lab's costmap, and read again by the readers of map files and of recordings."""
    http = service.http
    world = service.begin(kind="simulation", story={"steps": 40}, playing=False)
    address = f"/api/sessions/{world}/costmap"
    assert http.get(f"{address}/costmap.pgm").json()["code"] == "costmap.off"
    assert http.get(f"{address}/else.pgm").json()["code"] == "costmap.no_file"
    session = service.state.sessions.get(world)
    session.post(command_of({"type": "costmap"}))
    until(lambda: http.get(f"{address}/costmap.yaml").status_code == 200)
    assert http.get(f"{address}/keepout.pgm").json()["code"] == "costmap.no_zones"
    zone = {"width": 0.5, "erases": False, "points": [[2.0, 2.0]]}
    session.post(command_of({"type": "costmap", "keepout": [zone, zone | {"points": [[4.0, 2.0]], "speed": 30}]}))
    until(lambda: http.get(f"{address}/keepout.yaml").status_code == 200)
    for name in (
        "costmap.pgm",
        "costmap.yaml",
        "costmap.mcap",
        "keepout.pgm",
        "keepout.yaml",
        "speed.pgm",
        "speed.yaml",
    ):
        answer = http.get(f"{address}/{name}")
        named = re.search('filename="([^"]+)"', answer.headers["content-disposition"])
        assert named is not None
        (tmp_path / (named[1] if name != "costmap.mcap" else name)).write_bytes(answer.content)
    costed = session.model.find(Costed)
    assert costed is not None
    expected = costed.present_costs()
    assert expected is not None
    (stream,) = open_costmaps(tmp_path / "costmap.mcap").values()
    np.testing.assert_array_equal(stream[0].costs, expected.costs)
    assert stream[0].geometry == expected.geometry
    image = next(tmp_path.glob("*_costmap.pgm")).read_bytes()
    assert image.endswith(np.ascontiguousarray(expected.costs[::-1]).tobytes())
    mask = load_map(tmp_path / "keepout.yaml")
    assert mask.grid.geometry == expected.geometry
    assert set(np.unique(mask.values)) == {0, 100}
    at = expected.geometry.world_to_cell((2.0, 2.0))
    assert mask.values[at[0], at[1]] == 100
    assert (expected.costs[mask.values == 100] >= 253).all()
    # The masks are those that the Nav2 parameter file of painted_filters names, relative to itself.
    filters = painted_filters(mask.values, mask.values, "percentage")
    masks = load_masks(replace(DEFAULT, filters=filters), tmp_path)
    assert (masks["speed_filter"].at(4.0, 2.0), masks["speed_filter"].at(2.0, 2.0)) == (30, 0)
    assert masks["keepout_filter"].at(2.0, 2.0) == 100
