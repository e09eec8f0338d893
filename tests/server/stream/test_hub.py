"""A client ends with the state of the server after any sequence of events, and never gets outdated state."""

from __future__ import annotations

import json
import struct
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mapper.grid import CellBox
from server.parts.notes.messages import NotesMessage
from server.stream.grid_layer import MOST_CHANGES
from server.stream.hub import ACK_TIMEOUT_S, MAX_ANSWERS, SLOW_ACK_S, Client
from server.stream.messages import Pong, ScanFields
from server.stream.protocol import ProtocolError
from tests.server.stream.simulated_browser import COLS, ROWS, TICK_S, Browser, Source, frame_message

ACTIONS = st.lists(
    st.one_of(
        st.tuples(
            st.just("paint"), st.integers(0, 1000), st.integers(0, 1000), st.sampled_from([-2.0, -0.4, 0.0, 0.85, 3.5])
        ),
        st.tuples(
            st.just("fill"), st.integers(0, 200), st.integers(0, 200), st.integers(1, 99), st.sampled_from([-1.0, 1.0])
        ),
        st.tuples(st.just("publish")),
        st.tuples(st.just("read")),
        st.tuples(st.just("ack")),
        st.tuples(st.just("reconnect")),
        st.tuples(st.just("wait"), st.sampled_from([0.01, 0.2, 1.0])),
        st.tuples(st.just("epoch"), st.integers(1, 300), st.integers(1, 300)),
    ),
    max_size=60,
)


@given(ACTIONS)
def test_in_the_end_every_client_has_the_picture(actions: list[tuple[Any, ...]]) -> None:
    source = Source()
    source.publish()
    browser, idle = Browser(source), Browser(source)
    for name, *arguments in actions:
        match name:
            case "paint":
                source.paint(*arguments)
            case "fill":
                row, col, side, value = arguments
                source.fill(row, col, side, side, value)
            case "publish":
                source.publish()
            case "read":
                browser.read()
            case "ack":
                browser.acknowledge()
            case "reconnect":
                browser.reconnect()
            case "wait":
                source.clock.now += arguments[0]
            case "epoch":
                source.new_epoch(*arguments)
    for one in (browser, idle):
        source.publish(settled=True)
        for _ in range(100):
            one.acknowledge()
            source.clock.now += 1.0
            if not one.read():
                break
        assert one.epoch == source.epoch
        assert one.cells.tobytes() == source.picture.cells.tobytes()
        assert one.client.dirty_tiles == 0


def test_at_most_two_frames_are_unacknowledged_and_one_where_acknowledgements_are_slow() -> None:
    source = Source()
    source.publish()
    browser = Browser(source)

    def sent_without_acknowledging() -> int:
        before = browser.seq
        for _ in range(10):
            source.clock.now += TICK_S
            source.publish()
            browser.read()
        return browser.seq - before

    assert sent_without_acknowledging() == 1  # nothing is known of the client yet
    browser.acknowledge()
    for _ in range(20):  # now it is quick, for long enough that the slow start is forgotten
        source.clock.now += 0.01
        browser.acknowledge()
        source.publish()
        browser.read()
    browser.acknowledge()
    assert bool(browser.client.is_slow) is False
    assert sent_without_acknowledging() == 2
    source.clock.now += SLOW_ACK_S + 0.05
    browser.acknowledge()
    assert bool(browser.client.is_slow) is True
    assert sent_without_acknowledging() == 1


@pytest.mark.parametrize("period", [0.5, 0.3, 1.0])
def test_a_slow_client_gets_state_no_older_than_its_period(period: float) -> None:
    """The server ticks at 30 Hz; the client empties its socket only every ``period`` seconds, and then acknowledges."""
    source = Source()
    source.publish()
    slow = Browser(source)
    fast = Browser(source)
    ages: list[float] = []
    socket: list[float] = []  # the times of the frames that wait in the slow client's socket
    ticks = 0
    next_read = source.clock.now + period
    while ticks < 600:
        source.clock.now += TICK_S
        ticks += 1
        source.paint(ticks * 7, ticks * 13, 0.85)
        source.publish()
        fast.read()
        fast.acknowledge()
        before = len(slow.times)
        slow.read()
        socket += slow.times[before:]
        if source.clock.now >= next_read:
            next_read += period
            ages += [source.clock.now - t for t in socket]
            socket = []
            slow.acknowledge()
            before = len(slow.times)
            slow.read()  # what goes out at once
            socket += slow.times[before:]
    reads = int(600 * TICK_S / period)
    assert len(ages) >= reads - 2  # it gets something new at every look
    assert ages[0] <= period + 1e-6  # sent when it came
    assert max(ages[1:]) < 0.95 * period  # room for the line and for clocks
    assert len(fast.times) >= 599  # and nobody else notices


def test_a_paused_session_is_true_now() -> None:
    source = Source()
    source.publish(settled=True)
    source.clock.now += 1000.0
    browser = Browser(source)
    browser.read()
    assert browser.times == [pytest.approx(source.clock.now)]


def test_nothing_is_sent_where_nothing_changes() -> None:
    source = Source()
    source.paint(3, 3, 0.85)
    source.publish(settled=True)
    browser = Browser(source)
    assert browser.read() == 4  # layers, geometry, frame, tiles
    browser.acknowledge()
    source.clock.now += 1.0
    assert browser.read() == 0


def test_tiles_near_the_robot_are_sent_first_in_frames_of_limited_size() -> None:
    source = Source(64 * 40, 64 * 40)
    rng = np.random.default_rng(0)
    source.grid.log_odds[:] = rng.normal(size=source.grid.log_odds.shape)  # does not compress: 1,600 full tiles
    source.grid.observed[:] = True
    source.layer.update(source.grid, source.config, None, whole=True)
    at = (64 * 30 + 32, 64 * 10 + 32)
    source.hub.publish(frame_message(0), ScanFields(), (at[1] * 0.1, at[0] * 0.1), settled=True)
    browser = Browser(source)
    sizes = []
    for _ in range(1000):
        out = browser.client.take()
        if not out:
            break
        for message in out:
            if isinstance(message, bytes):
                sizes.append(len(message))
                browser._apply(message)
            else:
                browser._hear(json.loads(message))
        source.clock.now += 0.01
        browser.acknowledge()
        source.clock.now += 0.01
    assert max(sizes) <= 260 * 1024
    assert len(sizes) > 10
    away = [np.hypot(ty - 30, tx - 10) for ty, tx in browser.order]
    assert away == sorted(away)
    assert browser.cells.tobytes() == source.picture.cells.tobytes()


def test_a_client_whose_frames_are_late_because_they_are_large_gets_smaller_ones() -> None:
    source = Source(64 * 12, 64 * 12)
    rng = np.random.default_rng(1)
    source.grid.observed[:] = True
    browser = Browser(source)
    bytes_per_s = 60_000.0
    sizes = []
    for _ in range(60):
        source.grid.log_odds[:] = rng.normal(size=source.grid.log_odds.shape)
        source.layer.update(source.grid, source.config, None, whole=True)
        source.publish(settled=True)
        size = 0
        for message in browser.client.take():
            size += len(message)
            if isinstance(message, bytes):
                browser._apply(message)
            else:
                browser._hear(json.loads(message))
        sizes.append(size)
        source.clock.now += 0.03 + size / bytes_per_s
        browser.acknowledge()
        source.clock.now += 0.2
    assert max(sizes[-10:]) < 40_000  # well below a second on that line
    assert min(sizes[-10:]) > 4_000


def test_a_client_that_never_acknowledges_is_dropped_after_a_time() -> None:
    source = Source()
    source.publish()
    client = source.hub.join()
    client.take()
    assert bool(client.is_lost) is False
    source.clock.now += ACK_TIMEOUT_S + 1.0
    assert bool(client.is_lost) is True
    assert client.wait_s() < 1.0


def test_a_frame_that_is_held_back_is_never_forgotten() -> None:
    """The instant at which it may go can pass between two looks at the clock: here every look takes a while."""
    source = Source()
    source.publish(settled=True)
    browser = Browser(source)
    browser.read()
    for looks_take in np.linspace(1e-3, 0.019, 40):
        source.publish(settled=True)
        source.clock.now += 0.2
        browser.acknowledge()

        def slowly(step: float = float(looks_take)) -> float:
            source.clock.now += step
            return source.clock.now

        source.hub.clock = slowly
        for _ in range(200):
            if browser.read():
                break
            wait = browser.client.wait_s()
            assert wait < 1.0
            source.clock.now += wait
        else:
            pytest.fail("the frame was never sent")
        source.hub.clock = source.clock


def test_answers_do_not_pile_up() -> None:
    source = Source()
    source.publish()
    client = source.hub.join()
    client.take()
    for i in range(10 * MAX_ANSWERS):
        client.send(Pong(i, 0.0))
        source.hub.set_slot(NotesMessage(float(i)))
    out = client.take()
    assert len(out) == MAX_ANSWERS + 1
    assert json.loads(out[0])["changed_s"] == 10 * MAX_ANSWERS - 1
    assert json.loads(out[-1])["id"] == 10 * MAX_ANSWERS - 1


@pytest.mark.parametrize("seq", [-1, 2, 2**40])
def test_acknowledging_an_unsent_frame_is_refused(seq: int) -> None:
    source = Source()
    source.publish()
    client: Client = source.hub.join()
    client.take()
    with pytest.raises(ProtocolError, match="was not sent"):
        client.acknowledge(seq)


def test_resume_of_another_epoch_changes_nothing() -> None:
    source = Source()
    source.paint(3, 3, 0.85)
    source.publish()
    client = source.hub.join()
    client.resume("map", source.epoch + 1, 2**31)
    client.resume("no such", source.epoch, source.picture.newest)
    assert client.dirty_tiles == 1
    client.resume("map", source.epoch, source.picture.newest)
    assert client.dirty_tiles == 0


def test_few_changes_are_sent_alone_and_many_as_tiles() -> None:
    source = Source()
    source.paint(3, 4, 1.0)
    source.publish()
    browser, behind = Browser(source), Browser(source)
    for one in (browser, behind):
        one.read()
        one.acknowledge()
        assert one.kinds == {1: 1}
    for row in (70, 71):  # two updates, in two tiles each
        source.fill(row, 50, 1, 30, -1.0)
        source.publish()
        browser.read()
        browser.acknowledge()
    assert browser.kinds == {1: 1, 4: 2}
    assert browser.order[-4:] == 2 * [(1, 0), (1, 1)]
    behind.read()  # both updates at once
    behind.acknowledge()
    assert behind.kinds == {1: 1, 4: 1}
    assert source.hub.traffic.tiles == 2 + 4 + 2
    source.fill(0, 0, 64, MOST_CHANGES // 64 + 1, 2.0)
    source.publish()
    for one in (browser, behind):
        one.read()
        assert one.kinds[1] == 2
        assert one.cells.tobytes() == source.picture.cells.tobytes()


def test_a_client_that_missed_more_updates_than_are_kept_gets_tiles() -> None:
    source = Source()
    source.publish()
    behind, late = Browser(source), Browser(source)
    for one in (behind, late):
        one.read()
        one.acknowledge()
    for row in range(0, 160, 40):
        late.read()
        late.acknowledge()
        source.fill(row, 0, MOST_CHANGES // 100, 40, 1.0)
        source.publish()
    kinds = late.kinds.copy()
    for one in (behind, late):
        one.read()
        assert one.cells.tobytes() == source.picture.cells.tobytes()
    assert behind.kinds[4] == 0
    assert late.kinds - kinds == {4: 1}


def test_clients_with_the_same_tiles_are_sent_the_same_bytes_and_others_what_they_lack():
    source = Source()
    alike, other = [source.hub.join() for _ in range(2)], source.hub.join()
    rng = np.random.default_rng(1)
    sizes = []
    for step in range(6):
        rows, cols = int(rng.integers(0, ROWS - 9)), int(rng.integers(0, COLS - 9))
        source.grid.log_odds[rows : rows + 9, cols : cols + 9] = rng.uniform(-2.0, 3.5)
        source.grid.observed[rows : rows + 9, cols : cols + 9] = True
        source.layer.update(source.grid, source.config, CellBox(rows, rows + 9, cols, cols + 9), whole=False)
        source.publish()
        frames = [[one for one in client.take() if isinstance(one, bytes)] for client in alike]
        assert frames[0] == frames[1]
        for client, sent in zip(alike, frames, strict=True):
            client.acknowledge(struct.unpack_from("<BBHIII", sent[-1])[4])
        if step == 5:  # it has looked away for five ticks
            late = [one for one in other.take() if isinstance(one, bytes)]
            sizes = [struct.unpack_from("<BBHIII", sent[-1])[5] for sent in (frames[0], late)]
        source.clock.now += TICK_S
    assert sizes[1] > sizes[0] > 0
