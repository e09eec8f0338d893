"""Vectors that compare the pages' side of the protocol with the server: written here, read by the pages' tests.

``python tests/server/stream/test_protocol_vectors.py --write`` rewrites them after a change of the protocol.
"""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any, get_args

import msgspec
import numpy as np
import pytest
import zstandard

from mapper.core.se2 import compose
from mapper.grid import GridGeometry
from mapper.grid.kernels.quantise import NEVER_OBSERVED, quantise
from mapper.mapping.textbook_traversal import bresenham
from server.parts import wire
from server.parts.wire import decode_command
from server.stream.grid_layer import STATE_BOUNDS
from server.stream.protocol import (
    CHANGES,
    GRAPH,
    HEADER,
    TABLE,
    TILES,
    CellChanges,
    Graph,
    ProtocolError,
    TilePayload,
    encode_text,
    fields_of,
)
from tests.server.stream.examples import COMMANDS, MESSAGES
from tests.server.stream.frame_decoding import decode_frame, encode_frame

UNLISTED = np.empty(0, dtype=np.uint32)
VECTORS = Path(__file__).parents[3] / "static" / "src" / "wire" / "protocol.vectors.json"
TILE = 64


def cells(seed: int) -> np.ndarray[Any, np.dtype[np.int8]]:
    """Return a tile (64, 64) with every value of int8 in it."""
    rng = np.random.default_rng(seed)
    tile = rng.integers(-128, 128, (TILE, TILE), dtype=np.int8)
    tile[:4] = np.arange(-128, 128, dtype=np.int8).reshape(4, 64)
    return tile


def frames() -> list[dict[str, Any]]:
    """Binary frames with tiles, and what is in them."""
    out = []
    for epoch, seq, complete, places in (
        (1, 1, False, ()),
        (7, 4294967295, True, ((0, 0, 1), (-3, 300, 4294967295))),
        (4294967295, 2, False, ((32767, -32768, 5),)),
    ):
        pictures = [cells(10 * seq + i) for i in range(len(places))]
        tiles = [
            TilePayload(tx, ty, revision, zstandard.compress(picture.tobytes()))
            for (tx, ty, revision), picture in zip(places, pictures, strict=True)
        ]
        out.append(
            {
                "hex": encode_frame(TILES, tiles, layer=seq % 65536, epoch=epoch, seq=seq, complete=complete).hex(),
                "layer": seq % 65536,
                "epoch": epoch,
                "seq": seq,
                "complete": complete,
                "tiles": [
                    {"tx": t.tx, "ty": t.ty, "revision": t.revision, "cells": picture.tobytes().hex()}
                    for t, picture in zip(tiles, pictures, strict=True)
                ],
            }
        )
    return out


def tables() -> list[dict[str, Any]]:
    """Binary frames with a table, and its columns; null is NaN."""
    out = []
    for layer, epoch, seq, columns in (
        (1, 1, 1, [[], []]),
        (65535, 4294967295, 4294967295, [[0.5, -1.25, 3.0], [1e20, -0.125, 0.0], [0.0, None, 2.0]]),
        (2, 7, 9, [[1.0]]),
    ):
        table = np.array(columns, dtype=np.float32)
        frame = encode_frame(TABLE, table, layer=layer, epoch=epoch, seq=seq, complete=True)
        whole = [[None if np.isnan(v) else float(v) for v in column] for column in table]
        out.append({"hex": frame.hex(), "layer": layer, "epoch": epoch, "seq": seq, "columns": whole})
    return out


def graphs() -> list[dict[str, Any]]:
    """Binary frames with a graph, and what is in it."""
    out = []
    for layer, epoch, seq, columns, edges, values in (
        (1, 1, 1, [[], [], []], [], []),
        (4, 70000, 3, [[0.0, 1.0, 1.0], [0.0, 0.0, 2.0], [0.0, 1.5, 3.0]], [[0, 1], [1, 2], [2, 0]], [0.25, 0.5, -1.0]),
    ):
        graph = Graph(
            np.array(columns, dtype=np.float32),
            np.array(edges, dtype=np.uint32).reshape(-1, 2),
            np.array(values, dtype=np.float32),
        )
        frame = encode_frame(GRAPH, graph, layer=layer, epoch=epoch, seq=seq, complete=True)
        said: dict[str, Any] = {
            "layer": layer,
            "epoch": epoch,
            "seq": seq,
            "columns": columns,
            "edges": edges,
            "values": values,
        }
        out.append({"hex": frame.hex(), **said})
    return out


def changes() -> list[dict[str, Any]]:
    """Binary frames with changes of cells, and what is in them."""
    out = []
    for layer, epoch, seq, revision, tiles in (
        (1, 1, 1, 0, []),
        (65535, 4294967295, 2, 4294967295, [(-3, 300, [0, 4095, 64], [-128, 127, 1]), (32767, -32768, [7], [-1])]),
        (2, 7, 9, 3, [(0, 0, [], []), (0, 1, [5], [5])]),
    ):
        content = CellChanges(
            revision,
            np.array([(tx, ty, len(places), 0) for tx, ty, places, _ in tiles], dtype=np.int16).reshape(-1, 4),
            np.array([place for _, _, places, _ in tiles for place in places], dtype=np.uint16),
            np.array([value for _, _, _, values in tiles for value in values], dtype=np.int8),
        )
        frame = encode_frame(CHANGES, content, layer=layer, epoch=epoch, seq=seq, complete=True)
        said = [{"tx": tx, "ty": ty, "places": places, "values": values} for tx, ty, places, values in tiles]
        out.append(
            {"hex": frame.hex(), "layer": layer, "epoch": epoch, "seq": seq, "revision": revision, "tiles": said}
        )
    return out


def broken() -> list[dict[str, str]]:
    """Frames that cannot be read, and the code that says why."""
    payloads = [TilePayload(0, 0, 1, b"abcdef"), TilePayload(1, 0, 2, b"gh")]
    nodes = np.zeros((2, 3), dtype=np.float32)
    edge, value = np.array([[0, 2]], dtype=np.uint32), np.zeros(1, dtype=np.float32)
    bad = []
    for whole in (
        encode_frame(TILES, payloads, layer=1, epoch=1, seq=1),
        encode_frame(TABLE, nodes, layer=1, epoch=1, seq=1),
        encode_frame(GRAPH, Graph(nodes, edge, value), layer=1, epoch=1, seq=1),
        encode_frame(CHANGES, cells_at(4095), layer=1, epoch=1, seq=1),
    ):
        bad += [whole[:cut] for cut in range(0, len(whole), 5)] + [whole + b"x", b"\x09" + whole[1:]]
    bad += [b"", encode_frame(GRAPH, Graph(nodes, edge + 1, value), layer=1, epoch=1, seq=1)]
    bad += [encode_frame(CHANGES, cells_at(4096), layer=1, epoch=1, seq=1)]
    bad += [HEADER.pack(kind, 0, 0, 1, 1, 0xFFFFFFFF) + bytes([255] * 8) for kind in (1, 2, 3, 4)]
    out = []
    for frame in bad:
        with pytest.raises(ProtocolError) as error:
            decode_frame(frame)
        out.append({"hex": frame.hex(), "code": error.value.code})
    return out


def cells_at(place: int) -> CellChanges:
    """Changes of two cells of tile (0, 1), at places 3 and ``place``."""
    tiles, places = np.array([[0, 1, 2, 0]], dtype=np.int16), np.array([3, place], dtype=np.uint16)
    return CellChanges(5, tiles, places, np.array([1, -1], dtype=np.int8))


def lattices() -> list[dict[str, Any]]:
    """Points, the cells that hold them, and the cells' centres."""
    rng = np.random.default_rng(3)
    out = []
    for origin in ((0.0, 0.0, 0.0), (-12.8, 3.2, 0.0), (5.0, -7.0, 0.7)):
        geometry = GridGeometry(0.05, 640, 320, origin)
        points = rng.uniform(-20.0, 20.0, (20, 2))
        rc = geometry.world_to_cell(points)
        out.append(
            {
                "origin": list(origin),
                "resolution": 0.05,
                "rows": 640,
                "cols": 320,
                "points": points.tolist(),
                "cells": rc.tolist(),
                "centres": geometry.cell_to_world(rc).tolist(),
                "inside": geometry.contains(rc).tolist(),
            }
        )
    return out


def quantised() -> dict[str, Any]:
    """Log-odds, and the int8 that stand for them."""
    low, high = -2.0, 3.5
    values = np.linspace(-2.5, 4.0, 40, dtype=np.float32)[None, :]
    observed = np.ones_like(values, dtype=np.bool_)
    observed[0, 0] = False
    picture = np.full(values.shape, NEVER_OBSERVED, dtype=np.int8)
    quantise(
        values,
        observed,
        low,
        high,
        *STATE_BOUNDS,
        0,
        1,
        0,
        40,
        TILE,
        picture,
        np.zeros((1, 1), dtype=np.bool_),
        UNLISTED,
        0,
    )
    return {
        "low": low,
        "high": high,
        "log_odds": np.clip(values[0], low, high).astype(float).tolist(),
        "observed": observed[0].tolist(),
        "int8": picture[0].tolist(),
    }


def lines() -> list[dict[str, Any]]:
    """Bresenham's lines in all octants, zero length included."""
    ends = [(0, 0), (3, 4), (-3, 4), (4, 3), (4, -3), (-4, -3), (-3, -4), (3, -4), (0, 7), (-7, 0), (5, 5), (1, 9)]
    return [{"end": list(end), "cells": [list(cell) for cell in bresenham((2, -1), end)]} for end in ends]


def vectors() -> dict[str, Any]:
    """Everything, as JSON has it."""
    made = {
        "frames": frames(),
        "tables": tables(),
        "graphs": graphs(),
        "changes": changes(),
        "broken": broken(),
        "messages": [encode_text(message) for message in MESSAGES],
        "commands": [json.dumps(command, separators=(",", ":")) for command in COMMANDS],
        "lattices": lattices(),
        "compose": [
            {"a": list(a), "b": list(b), "c": compose(np.array(a), np.array(b)).tolist()}
            for a, b in (((1.0, 2.0, 0.5), (0.3, -0.1, 0.2)), ((0.0, 0.0, -1.5), (1.0, 1.0, 0.0)))
        ],
        "quantised": quantised(),
        "lines": lines(),
    }
    whole: dict[str, Any] = json.loads(json.dumps(made))
    return whole


def without_compression(frame: dict[str, Any]) -> dict[str, Any]:
    """Return a frame's vector with its tiles decompressed: how they are compressed may differ between zstd versions."""
    decoded = decode_frame(bytes.fromhex(frame["hex"]))
    read = [(t.tx, t.ty, t.revision, zstandard.decompress(t.data).hex()) for t in decoded.content]
    return {key: value for key, value in frame.items() if key != "hex"} | {
        "read": read,
        "header": (decoded.layer, decoded.epoch, decoded.seq),
    }


def test_the_vectors_of_the_pages_are_current() -> None:
    kept = json.loads(VECTORS.read_text(encoding="utf-8"))
    fresh = vectors()
    assert [without_compression(f) for f in kept.pop("frames")] == [without_compression(f) for f in fresh.pop("frames")]
    assert kept == fresh, f"stale: run python {Path(__file__).relative_to(VECTORS.parents[3])} --write"


def test_the_commands_of_the_vectors_are_commands_to_the_server() -> None:
    kept = json.loads(VECTORS.read_text(encoding="utf-8"))
    for text, given in zip(kept["commands"], COMMANDS, strict=True):
        read = json.loads(json.dumps(fields_of(decode_command(text))))
        assert {name: read.get(name) for name in given} == given


def tags(union: Any) -> set[Any]:
    return {cls.__struct_config__.tag for cls in get_args(union)}


def test_the_vectors_have_every_message_and_command() -> None:
    kept = json.loads(VECTORS.read_text(encoding="utf-8"))
    assert {json.loads(text)["type"] for text in kept["messages"]} == tags(wire.ServerMessage)
    assert {json.loads(text)["type"] for text in kept["commands"]} == tags(wire.Command)


def test_the_messages_of_the_vectors_are_read_back() -> None:
    kept = json.loads(VECTORS.read_text(encoding="utf-8"))
    for text, message in zip(kept["messages"], MESSAGES, strict=True):
        assert msgspec.json.decode(text, type=wire.ServerMessage) == message


if __name__ == "__main__" and "--write" in sys.argv:
    VECTORS.write_text(json.dumps(vectors(), indent=1) + "\n", encoding="utf-8")
