"""Several layers over one socket: what each client gets, in which order, and that none disturbs another."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

from mapper.grid import GridGeometry
from server.stream.grid_layer import GridLayer
from server.stream.hub import MIN_BATCH_BYTES, Hub
from server.stream.layers import GraphLayer, Layer, TableLayer
from server.stream.messages import ScanFields
from server.stream.protocol import CHANGES, GRAPH, TILES
from tests.server.stream.applied_frames import apply_frame
from tests.server.stream.frame_decoding import decode_frame, decode_table
from tests.server.stream.simulated_browser import Clock, frame_message

SHAPE = (128, 192)
GEOMETRY = GridGeometry(0.1, *SHAPE)


class Shown:
    """A session's layers, and its hub."""

    def __init__(self, *layers: Layer) -> None:
        self.clock = Clock()
        self.hub = Hub(layers, self.clock)

    def publish(self) -> None:
        self.hub.publish(frame_message(0), ScanFields(), (0.0, 0.0), settled=True)


class Page:
    """A page that keeps what it is sent, by the name of the layer."""

    def __init__(self, shown: Shown, *names: str) -> None:
        self.shown = shown
        self.client = shown.hub.join()
        if names:
            self.client.subscribe(names)
        self.names: dict[int, str] = {}
        self.epochs: dict[str, int] = {}
        self.cells: dict[str, NDArray[np.int8]] = {}
        self.contents: dict[str, Any] = {}
        self.seq = 0
        self.frames: list[tuple[str, int]] = []  #: name of the layer and size of each frame that had something
        self.tiles = 0
        self.revisions: dict[str, int] = {}

    def read(self) -> int:
        """Take what is sent; return the number of binary frames."""
        before = self.seq
        for message in self.client.take():
            if isinstance(message, bytes):
                self._apply(message)
            else:
                self._hear(json.loads(message))
        return self.seq - before

    def _hear(self, message: dict[str, Any]) -> None:
        if message["type"] == "layers":
            self.names = {one["id"]: one["name"] for one in message["layers"]}
        if message["type"] == "geometry":
            name = self.names[message["layer"]]
            self.epochs[name] = message["epoch"]
            self.cells[name] = np.full((message["rows"], message["cols"]), -128, dtype=np.int8)

    def _apply(self, data: bytes) -> None:
        frame = decode_frame(data)
        assert frame.seq == self.seq + 1
        self.seq = frame.seq
        if frame.kind == TILES.kind and not frame.content:
            return
        name = self.names[frame.layer]
        self.frames.append((name, len(data)))
        if frame.kind not in {TILES.kind, CHANGES.kind}:
            self.contents[name] = frame.content
            return
        assert frame.epoch == self.epochs[name]
        revision, places = apply_frame(data, self.cells[name])
        self.revisions[name] = max(self.revisions.get(name, 0), revision)
        self.tiles += len(places)

    def catch_up(self) -> None:
        """Read and acknowledge until nothing comes any more."""
        for _ in range(1000):
            self.client.acknowledge(self.seq)
            self.shown.clock.now += 0.01
            if not self.read():
                return
        raise AssertionError("it never ends")


def noise(seed: int, shape: tuple[int, int] = SHAPE) -> NDArray[np.float32]:
    """Values that do not compress."""
    return np.random.default_rng(seed).random(shape, dtype=np.float32)


def grid(name: str) -> GridLayer:
    layer = GridLayer(name, name, "values")
    layer.set(GEOMETRY, noise(0), 0.0, 1.0)
    return layer


def points(name: str, n: int = 100) -> TableLayer:
    layer = TableLayer(name, name, "particles", ("x", "y"))
    layer.set(np.zeros((2, n)))
    return layer


def same(page: Page, layer: GridLayer) -> bool:
    assert layer.picture is not None
    return page.cells[layer.name].tobytes() == layer.picture.cells.tobytes()


def test_a_client_gets_the_first_layer_until_it_subscribes() -> None:
    first, second, dots = grid("map"), grid("costs"), points("particles")
    shown = Shown(first, second, dots)
    shown.publish()
    page = Page(shown)
    page.catch_up()
    assert {name for name, _ in page.frames} == {"map"}
    assert [layer.is_watched for layer in (first, second, dots)] == [True, False, False]
    page.client.subscribe(["costs", "particles", "not yet"])
    assert [layer.is_watched for layer in (first, second, dots)] == [False, True, True]
    page.frames.clear()
    first.set(GEOMETRY, noise(1), 0.0, 1.0)
    shown.publish()
    page.catch_up()
    assert {name for name, _ in page.frames} == {"costs", "particles"}
    assert same(page, second)
    assert not same(page, first)
    # A name that was not there takes effect when it is.
    later = points("not yet", 3)
    shown.hub.set_layers([first, second, dots, later])
    shown.publish()
    page.catch_up()
    assert page.contents["not yet"].shape == (2, 3)


def test_a_client_without_subscriptions_gets_one_batch_without_frames() -> None:
    shown = Shown(grid("map"))
    shown.publish()
    page = Page(shown)
    page.client.subscribe([])
    assert page.read() == 1
    assert page.frames == []
    page.client.acknowledge(page.seq)
    assert page.read() == 0


@settings(max_examples=60)
@given(
    st.lists(
        st.one_of(
            st.tuples(st.just("grid"), st.sampled_from(["map", "costs"]), st.integers(0, 99)),
            st.tuples(st.just("points"), st.just("particles"), st.integers(0, 400)),
            st.tuples(st.just("epoch"), st.sampled_from(["map", "costs"]), st.integers(1, 150)),
            st.tuples(st.just("subscribe"), st.sets(st.sampled_from(["map", "costs", "particles"]))),
            st.tuples(st.just("without"), st.sampled_from(["costs", "particles"])),
            st.tuples(st.just("all")),
            st.tuples(st.just("publish")),
            st.tuples(st.just("read")),
            st.tuples(st.just("ack")),
        ),
        max_size=40,
    )
)
def test_in_the_end_a_client_has_all_that_it_wants_as_it_is(actions: list[tuple[Any, ...]]) -> None:
    grids, dots = {"map": grid("map"), "costs": grid("costs")}, points("particles")
    layers: dict[str, Layer] = {**grids, "particles": dots}
    shown = Shown(*layers.values())
    page = Page(shown, "map", "costs", "particles")
    for name, *arguments in actions:
        match name:
            case "grid":
                grids[arguments[0]].set(GEOMETRY, noise(arguments[1]), 0.0, 1.0)
            case "epoch":
                rows = arguments[1]
                grids[arguments[0]].set(GridGeometry(0.1, rows, 70), noise(rows, (rows, 70)), 0.0, 1.0)
            case "points":
                dots.set(np.full((2, arguments[1]), 1.5))
            case "subscribe":
                page.client.subscribe(sorted(arguments[0]))
            case "without":
                shown.hub.set_layers([layer for key, layer in layers.items() if key != arguments[0]])
            case "all":
                shown.hub.set_layers([*layers.values()])
            case "publish":
                shown.publish()
            case "read":
                page.read()
            case "ack":
                page.client.acknowledge(page.seq)
    shown.hub.set_layers([*layers.values()])
    page.client.subscribe([*layers])
    shown.publish()
    page.catch_up()
    assert all(same(page, layer) for layer in grids.values())
    count, parts = dots.body
    np.testing.assert_array_equal(page.contents["particles"], decode_table(count, b"".join(parts)))
    assert page.client.dirty_tiles == 0


def test_the_layers_of_a_batch_share_its_bytes_and_each_has_its_turn() -> None:
    """On a slow line a table that is larger than a batch may not keep tiles away, nor tiles the table."""
    big, small, table = grid("map"), grid("costs"), points("particles", 10_000)  # 80 kB; a tile has 4 kB
    shown = Shown(big, small, table)
    shown.publish()
    page = Page(shown, "map", "costs", "particles")
    batches: list[list[tuple[str, int]]] = []
    for turn in range(40):
        for k, layer in enumerate((big, small)):
            layer.set(GEOMETRY, noise(10 * turn + k), 0.0, 1.0)
        table.set(np.full((2, 10_000), float(turn)))
        shown.publish()
        before = len(page.frames)
        page.read()
        batches.append(page.frames[before:])
        if "particles" in {name for name, _ in batches[-1]}:
            assert page.contents["particles"][0, 0] == turn  # the newest there is, however late the line
        shown.clock.now += 0.03 + sum(size for _, size in batches[-1]) / 60_000.0
        page.client.acknowledge(page.seq)
        shown.clock.now += 0.3
    for name in ("map", "costs", "particles"):
        turns = [i for i, batch in enumerate(batches) if name in {one for one, _ in batch}]
        assert max(np.diff([-1, *turns, 40])) <= 3, name
    late = batches[10:]
    assert max(sum(size for name, size in batch if name != "particles") for batch in late) < 2 * MIN_BATCH_BYTES
    # Where the table takes all there is, nothing follows it.
    assert all(len(batch) == 1 for batch in late if batch[0][0] == "particles")


def test_the_window_counts_batches_and_the_last_number_acknowledges_one() -> None:
    layers = [grid("map"), grid("costs"), points("particles", 3)]
    shown = Shown(*layers)
    shown.publish()
    page = Page(shown, "map", "costs", "particles")
    assert page.read() == 3
    assert page.client.unacknowledged == 1
    page.client.acknowledge(2)  # of three
    assert page.client.unacknowledged == 1
    page.client.acknowledge(3)
    assert page.client.unacknowledged == 0


def test_a_new_epoch_of_one_layer_leaves_the_others_alone() -> None:
    first, second = grid("map"), grid("costs")
    shown = Shown(first, second)
    shown.publish()
    page = Page(shown, "map", "costs")
    page.catch_up()
    epochs, page.tiles = dict(page.epochs), 0
    page.frames.clear()
    second.set(GridGeometry(0.05, 70, 70), noise(3, (70, 70)), 0.0, 1.0)
    shown.publish()
    page.catch_up()
    assert {name for name, _ in page.frames} == {"costs"}
    assert page.epochs["map"] == epochs["map"]
    assert page.epochs["costs"] > epochs["costs"]
    assert same(page, first)
    assert same(page, second)


def test_each_grid_is_resumed_by_its_name_in_its_own_epoch() -> None:
    first, second = grid("map"), grid("costs")
    shown = Shown(first, second)
    shown.publish()
    page = Page(shown, "map", "costs")
    page.catch_up()
    second.set(GEOMETRY, noise(4), 0.0, 1.0)
    shown.publish()
    again = Page(shown)
    for name in ("map", "costs"):
        again.client.resume(name, page.epochs[name], page.revisions[name])
    again.client.subscribe(["map", "costs"])
    again.catch_up()
    assert {name for name, _ in again.frames} == {"costs"}
    # The epoch of one layer says nothing of another.
    other = Page(shown)
    other.client.resume("costs", page.epochs["map"], 10**6)
    other.client.subscribe(["costs"])
    other.catch_up()
    assert same(other, second)


def test_a_new_layer_of_the_same_name_is_another_layer() -> None:
    first, old = grid("map"), grid("second_map")
    shown = Shown(first, old)
    shown.publish()
    page = Page(shown, "map", "second_map")
    page.catch_up()
    kept = page.epochs["second_map"], page.revisions["second_map"]
    shown.hub.set_layers([first])
    shown.publish()
    page.read()
    new = grid("second_map")
    new.set(GEOMETRY, noise(8), 0.0, 1.0)
    shown.hub.set_layers([first, new])
    shown.publish()
    assert shown.hub.id_of(new) > 2
    again = Page(shown)
    again.client.resume("second_map", *kept)
    again.client.subscribe(["second_map"])
    for one in (page, again):
        one.catch_up()
        assert same(one, new)


def test_a_layer_is_sent_completely_after_a_new_subscription() -> None:
    first, second = grid("map"), grid("costs")
    shown = Shown(first, second)
    shown.publish()
    page = Page(shown, "map", "costs")
    page.catch_up()
    page.client.subscribe(["map"])
    page.client.subscribe(["map", "costs"])
    page.cells["costs"].fill(-128)
    page.catch_up()
    assert same(page, second)


def test_two_layers_of_one_name_are_a_defect() -> None:
    with pytest.raises(ValueError, match="one name"):
        Hub([grid("map"), grid("map")])


def test_a_table_is_encoded_once_for_all_and_sent_again_only_when_it_changes() -> None:
    dots = points("particles", 4)
    shown = Shown(dots)
    shown.publish()
    pages = [Page(shown, "particles") for _ in range(3)]
    body = dots.body
    for page in pages:
        page.catch_up()
        assert len(page.frames) == 1
    dots.set(np.zeros((2, 4)))
    shown.publish()
    assert dots.body is body
    for page in pages:
        page.catch_up()
        assert len(page.frames) == 1


def test_changes_take_effect_when_they_are_published() -> None:
    first, dots = grid("map"), points("particles", 2)
    shown = Shown(first, dots)
    shown.publish()
    page = Page(shown, "map", "particles")
    page.catch_up()
    first.set(GridGeometry(0.2, 64, 64), noise(2, (64, 64)), 0.0, 1.0)
    dots.set([[1.0], [2.0]])
    page.catch_up()
    assert page.cells["map"].shape == SHAPE
    assert page.contents["particles"].shape == (2, 2)
    shown.publish()
    page.catch_up()
    assert page.cells["map"].shape == (64, 64)
    assert page.contents["particles"].tolist() == [[1.0], [2.0]]


def test_a_graph_arrives_as_it_is() -> None:
    layer = GraphLayer("poses", "Poses", "constraints", ("x", "y", "yaw"))
    shown = Shown(layer)
    shown.publish()
    page = Page(shown, "poses")
    page.catch_up()
    assert page.frames == []  # nothing was set yet
    nodes = np.arange(12.0, dtype=np.float32).reshape(3, 4)
    layer.set(nodes, [(0, 1), (3, 1)], [0.5, 1.0])
    shown.publish()
    page.catch_up()
    content = page.contents["poses"]
    np.testing.assert_array_equal(content.nodes, nodes)
    assert (content.edges.tolist(), content.values.tolist()) == ([[0, 1], [3, 1]], [0.5, 1.0])
    assert layer.codec is GRAPH
    for edges, values in (([(0, 4)], [1.0]), ([(-1, 0)], [1.0]), ([(0, 1)], [])):
        with pytest.raises(ValueError, match="not a graph"):
            layer.set(nodes, edges, values)


def test_values_that_do_not_fit_are_refused() -> None:
    dots, costs = points("particles"), grid("costs")
    for columns in (np.zeros((3, 5)), np.zeros(2), [[1.0, 2.0], [1.0]]):
        with pytest.raises(ValueError, match=r"columns|inhomogeneous"):
            dots.set(columns)
    for values, low, high in ((noise(0, (3, 3)), 0.0, 1.0), (noise(0), 1.0, 1.0)):
        with pytest.raises(ValueError, match="do not fit a grid"):
            costs.set(GEOMETRY, values, low, high)
