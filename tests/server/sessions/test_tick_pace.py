"""The time from one tick to the next, by what clients have acknowledged and how long ticks wait for a thread."""

from __future__ import annotations

import struct

import pytest

from server.sessions.computation import MAX_TICK_S, OVERLOADED_TICK_S, TICK_S, TickPace
from server.stream.hub import WINDOW, Client
from tests.server.stream.simulated_browser import Source


def _take(client: Client) -> int:
    """Take what is sent; return the number of the last frame."""
    return int(max(struct.unpack_from("<BBHIII", one)[4] for one in client.take() if isinstance(one, bytes)))


def _quick(source: Source) -> Client:
    """Return a client that has acknowledged quickly for long enough to be sent two frames at once."""
    client = source.hub.join()
    while client.is_slow:
        source.clock.now += TICK_S
        source.publish()
        seq = _take(client)
        source.clock.now += 0.01
        client.acknowledge(seq)
    return client


@pytest.mark.parametrize(
    ("waited_s", "periods"),
    [
        (0.9 * TICK_S, [TICK_S, TICK_S, MAX_TICK_S]),
        (1.1 * TICK_S, [TICK_S, OVERLOADED_TICK_S, OVERLOADED_TICK_S]),
    ],
)
def test_the_next_frame_waits_for_an_acknowledgement_where_ticks_wait_for_threads(
    waited_s: float, periods: list[float]
) -> None:
    source, pace = Source(), TickPace()
    client = _quick(source)
    pace.waited_s = waited_s
    seq, found = 0, []
    for unacknowledged in range(WINDOW + 1):
        assert client.unacknowledged == unacknowledged
        found.append(pace.tick_s(source.hub, has_listeners=False))
        assert pace.is_full == (found[-1] != TICK_S)
        if unacknowledged < WINDOW:
            source.publish()
            seq = _take(client)
    assert found == periods
    assert pace.tick_s(source.hub, has_listeners=True) == TICK_S
    client.acknowledge(seq)
    assert pace.tick_s(source.hub, has_listeners=False) == TICK_S
    assert not pace.is_full


def test_one_client_that_has_acknowledged_is_enough() -> None:
    source, pace = Source(), TickPace()
    pace.waited_s = 1.0
    clients = [_quick(source) for _ in range(2)]
    source.publish()
    seqs = [_take(client) for client in clients]
    assert pace.tick_s(source.hub, has_listeners=False) == OVERLOADED_TICK_S
    clients[1].acknowledge(seqs[1])
    assert pace.tick_s(source.hub, has_listeners=False) == TICK_S
