"""viser's messages go out in parts of a limited size."""

from __future__ import annotations

import numpy as np
import pytest
from viser._messages import ImageMessage, ImageProps, SceneNodeUpdateMessage, SetPositionMessage
from viser.infra import Message

from server.scenes.viser_server import MAX_TOGETHER, MessageBuffer, ViserServer, parts_of, size_of


def sized(size: int) -> Message:
    return SceneNodeUpdateMessage("/a", {"points": np.zeros(size, np.uint8)})


def test_the_size_is_that_of_arrays_and_bytes() -> None:
    assert size_of(sized(1000)) == 1000
    props = ImageProps("png", b"x" * 77, 1.0, 1.0, cast_shadow=False, receive_shadow=False, scale=1.0)
    assert size_of(ImageMessage("/a", props)) == 77
    assert size_of(SetPositionMessage("/a", (0.0, 0.0, 0.0))) == 0


@pytest.mark.parametrize(
    ("sizes", "parts"),
    [
        ([], []),
        ([1, 2, 3], [3]),
        ([MAX_TOGETHER, 0, 1], [2, 1]),
        ([1, 2 * MAX_TOGETHER, 1, 1], [1, 1, 2]),
        ([MAX_TOGETHER // 2] * 5, [2, 2, 1]),
        ([9 * MAX_TOGETHER], [1]),
    ],
)
def test_messages_stay_in_order(sizes: list[int], parts: list[int]) -> None:
    window = [sized(size) for size in sizes]
    found = list(parts_of(window))
    assert [len(part) for part in found] == parts
    assert [message for part in found for message in part] == window


def test_viser_uses_it() -> None:
    server = ViserServer()
    assert isinstance(server._websock_server.get_message_buffer(), MessageBuffer)
    server.stop()
