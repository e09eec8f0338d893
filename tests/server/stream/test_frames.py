"""The frames of WebSocket messages are those that the library websockets reads and writes."""

from __future__ import annotations

import numpy as np
import pytest
from websockets.frames import Frame, Opcode
from websockets.streams import StreamReader

from server.stream.frames import binary_frame, text_frame
from server.stream.hub import Hub
from server.stream.layers import TableLayer
from server.stream.messages import ScanFields
from tests.server.stream.simulated_browser import frame_message


def parsed(data: bytes) -> Frame:
    """Return the only frame in ``data``, as a client reads it."""
    reader = StreamReader()
    reader.feed_data(data)
    reader.feed_eof()
    parsing = Frame.parse(reader.read_exact, mask=False, max_size=None)
    try:
        while True:
            next(parsing)
    except StopIteration as done:
        assert not reader.buffer
        frame: Frame = done.value
        return frame


@pytest.mark.parametrize("length", [0, 1, 125, 126, 65_535, 65_536, 200_000])
def test_a_client_reads_what_was_sent(length):
    data = np.random.default_rng(length).integers(0, 256, length, dtype=np.uint8).tobytes()
    frame = parsed(binary_frame((data[: length // 3], data[length // 3 :])))
    assert (frame.opcode, frame.fin, bytes(frame.data)) == (Opcode.BINARY, True, data)
    text = "é" * length
    frame = parsed(text_frame(text))
    assert (frame.opcode, frame.fin, bytes(frame.data).decode()) == (Opcode.TEXT, True, text)


def test_a_text_is_encoded_once_for_all_clients():
    hub = Hub([TableLayer("points", "Points", "points", ("x", "y"))])
    hub.publish(frame_message(0), ScanFields(ranges=[1.0]), (0.0, 0.0), settled=False)
    clients = [hub.join() for _ in range(3)]
    sent = [[hub.text_frame(one) for one in client.take() if isinstance(one, str)] for client in clients]
    assert len(sent[0]) >= 2
    assert all(one is first for others in sent[1:] for one, first in zip(others, sent[0], strict=True))
    before = sent[0][-1]
    hub.publish(frame_message(1), ScanFields(ranges=[2.0]), (0.0, 0.0), settled=False)
    assert hub.text_frame(hub.frame_text()) != before
