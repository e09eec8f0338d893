"""Binary frames are decoded unchanged, and invalid ones are refused with one sentence."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from server.stream.protocol import (
    CHANGES,
    CODECS,
    GRAPH,
    TABLE,
    TILES,
    CellChanges,
    Codec,
    Graph,
    ProtocolError,
    TilePayload,
)
from tests.server.stream.frame_decoding import decode_frame, encode_frame

U16, U32 = st.integers(0, 2**16 - 1), st.integers(0, 2**32 - 1)
FLOATS = st.floats(width=32, allow_nan=True)
PAYLOADS = st.lists(
    st.builds(
        TilePayload,
        tx=st.integers(-(2**15), 2**15 - 1),
        ty=st.integers(-(2**15), 2**15 - 1),
        revision=U32,
        data=st.binary(max_size=40),
    ),
    max_size=5,
)
TABLES = arrays(np.float32, st.tuples(st.integers(0, 5), st.integers(0, 9)), elements=FLOATS)


@st.composite
def graphs(draw: st.DrawFn) -> Graph:
    nodes = draw(arrays(np.float32, st.tuples(st.integers(2, 4), st.integers(0, 6)), elements=FLOATS))
    n_edges = draw(st.integers(0, 8)) if nodes.shape[1] else 0
    places = st.integers(0, max(0, nodes.shape[1] - 1))
    return Graph(
        nodes,
        draw(arrays(np.uint32, (n_edges, 2), elements=places)),
        draw(arrays(np.float32, n_edges, elements=FLOATS)),
    )


@st.composite
def changes(draw: st.DrawFn) -> CellChanges:
    numbers = draw(st.lists(st.integers(0, 6), max_size=4))
    tiles = np.zeros((len(numbers), 4), dtype=np.int16)
    tiles[:, :2] = draw(arrays(np.int16, (len(numbers), 2)))
    tiles[:, 2] = numbers
    places = draw(arrays(np.uint16, sum(numbers), elements=st.integers(0, 4095)))
    return CellChanges(draw(U32), tiles, places, draw(arrays(np.int8, sum(numbers))))


CONTENTS = st.one_of(
    PAYLOADS.map(lambda content: (TILES, content)),
    TABLES.map(lambda content: (TABLE, content)),
    graphs().map(lambda content: (GRAPH, content)),
    changes().map(lambda content: (CHANGES, content)),
)


def assert_same(codec: Codec[Any], read: Any, content: Any) -> None:
    if codec is TILES:
        assert read == content
        return
    pairs = [(read, content)]
    if codec is GRAPH:
        pairs = [(read.nodes, content.nodes), (read.edges, content.edges), (read.values, content.values)]
    if codec is CHANGES:
        assert read.revision == content.revision
        pairs = list(zip(read[1:], content[1:], strict=True))
    for one, other in pairs:
        assert (one.shape, one.tobytes()) == (other.shape, other.tobytes())


@given(CONTENTS, U16, U32, U32, st.booleans())
def test_content_round_trip(sent: tuple[Codec[Any], Any], layer: int, epoch: int, seq: int, complete: bool) -> None:
    codec, content = sent
    frame = decode_frame(encode_frame(codec, content, layer=layer, epoch=epoch, seq=seq, complete=complete))
    assert (frame.kind, frame.layer, frame.epoch, frame.seq) == (codec.kind, layer, epoch, seq)
    assert frame.complete is complete
    assert_same(codec, frame.content, content)


def test_the_bytes_are_those_of_the_protocols_text() -> None:
    frame = encode_frame(TILES, [TilePayload(-2, 3, 9, b"zs")], layer=7, epoch=0x01020304, seq=5, complete=True)
    header = "01 01 0700 04030201 05000000 01000000"
    assert frame == bytes.fromhex(f"{header} feff 0300 09000000 02000000") + b"zs"
    table = np.array([[1.0, 2.0], [-1.0, np.inf], [0.0, 0.5]], dtype=np.float32)
    assert encode_frame(TABLE, table, layer=2, epoch=3, seq=4) == bytes.fromhex(
        "02 00 0200 03000000 04000000 02000000  0300 0000  0000803f 00000040  000080bf 0000807f  00000000 0000003f"
    )
    graph = Graph(table[:2], np.array([[1, 0]], dtype=np.uint32), np.array([2.0], dtype=np.float32))
    assert encode_frame(GRAPH, graph, layer=2, epoch=3, seq=4) == bytes.fromhex(
        "03 00 0200 03000000 04000000 02000000  0200 0000 01000000  0000803f 00000040  000080bf 0000807f"
        "01000000 00000000  00000040"
    )
    changes = CellChanges(
        9,
        np.array([[-2, 3, 2, 0], [1, 0, 1, 0]], dtype=np.int16),
        np.array([4095, 1, 64], dtype=np.uint16),
        np.array([-128, 5, 127], dtype=np.int8),
    )
    assert encode_frame(CHANGES, changes, layer=2, epoch=3, seq=4) == bytes.fromhex(
        "04 00 0200 03000000 04000000 02000000  09000000  feff 0300 0200 0000  0100 0000 0100 0000"
        "ff0f 0100 4000  80057f"
    )


@given(CONTENTS, st.data())
def test_every_cut_frame_is_refused(sent: tuple[Codec[Any], Any], data: st.DataObject) -> None:
    frame = encode_frame(*sent, layer=1, epoch=1, seq=1)
    with pytest.raises(ProtocolError):
        decode_frame(frame[: data.draw(st.integers(0, len(frame) - 1))])
    with pytest.raises(ProtocolError):
        decode_frame(frame + b"x")


def test_an_edge_to_no_node_is_refused() -> None:
    graph = Graph(
        np.zeros((2, 3), dtype=np.float32), np.array([[0, 3]], dtype=np.uint32), np.zeros(1, dtype=np.float32)
    )
    with pytest.raises(ProtocolError, match="node 3 of 3") as refused:
        decode_frame(encode_frame(GRAPH, graph, layer=1, epoch=1, seq=1))
    assert refused.value.code == "frame.edge"


def test_a_cell_beyond_its_tile_is_refused() -> None:
    tiles = np.array([[0, 0, 1, 0]], dtype=np.int16)
    outside = CellChanges(1, tiles, np.array([4096], dtype=np.uint16), np.zeros(1, dtype=np.int8))
    with pytest.raises(ProtocolError, match="4096 cells") as refused:
        decode_frame(encode_frame(CHANGES, outside, layer=1, epoch=1, seq=1))
    assert refused.value.code == "frame.cell"


def test_each_encoding_has_its_own_number() -> None:
    assert {name: codec.kind for name, codec in CODECS.items()} == {"grid": 1, "points": 2, "path": 2, "graph": 3}
