"""Depth images in sensor_msgs/CompressedImage, as written by ROS's compressed_depth_image_transport and others.

Source: ros-perception/image_transport_plugins, compressed_depth_image_transport (the format's string, the header of 12
bytes, the quantised inverse depth of 32FC1 images); A. D. Wilson, Fast lossless depth image compression, 2017 (RVL).
"""

from __future__ import annotations

import io
import re
import struct

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from mapper.io.logs.ros.cloud_messages import DEPTHS, DepthImage, NotDepthError
from mapper.io.logs.ros.message_fields import BadMessageError, MessageFields

COMPRESSED = "sensor_msgs/CompressedImage"
MOST_PIXELS = 1 << 23  #: of one image, because a small message may state any size
HEADER = "<i2f"  #: the kind of quantisation, which is not used, and its two parameters
LONGEST = 8  #: groups of three bits per number in RVL: 2²⁴ exceeds the number of pixels

_FORMAT = re.compile(r"(?P<encoding>\w+)\s*;\s*(?P<how>compressedDepth(?: (?P<coder>\w+))?|png compressed|\w*)\s*")
_PNG_ERRORS = (OSError, SyntaxError, ValueError, Image.DecompressionBombError)


def compressed_depth_image(data: bytes, *, cdr: bool) -> DepthImage:
    """Decode a sensor_msgs/CompressedImage of depths: a PNG, or RVL, with or without the transport's header.

    Raises :class:`NotDepthError` for a picture, and :class:`BadMessageError`.
    """
    fields = MessageFields(data, cdr=cdr)
    stamp, frame = fields.header()
    form = fields.string()
    values = fields.bytes()
    fields.end()
    match = _FORMAT.fullmatch(form)
    if match is None or match["encoding"] not in DEPTHS:
        raise NotDepthError(form)
    is_float = DEPTHS[match["encoding"]][0] == "f4"
    if not match["how"].startswith("compressedDepth"):
        if is_float or "png" not in match["how"]:
            raise NotDepthError(form)
        return DepthImage(stamp, frame, _png(values), DEPTHS[match["encoding"]][1])
    coder = match["coder"] or "png"
    if coder not in ("png", "rvl"):
        raise BadMessageError(f"depth images compressed by {coder!r:.20} are not read")
    try:
        _, a, b = struct.unpack_from(HEADER, values)
    except struct.error:
        raise BadMessageError(f"its {len(values)} bytes are too few for a compressed depth image") from None
    packed = values[struct.calcsize(HEADER) :]
    raw = _png(packed) if coder == "png" else _rvl(packed)
    if not is_float:
        return DepthImage(stamp, frame, raw, DEPTHS[match["encoding"]][1])
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        metres = np.float32(a) / (raw.astype(np.float32) - np.float32(b))
    metres[raw == 0] = np.nan
    return DepthImage(stamp, frame, metres, 1.0)


def _check_size(width: int, height: int) -> None:
    if not 0 < width * height <= MOST_PIXELS:
        raise BadMessageError(f"a compressed image of {width} × {height} pixels")


def _png(packed: memoryview) -> NDArray[np.uint16]:
    try:
        with Image.open(io.BytesIO(packed), formats=("PNG",)) as image:
            _check_size(*image.size)
            if not image.mode.startswith("I"):
                raise BadMessageError(f"its PNG is not grey with 16 bits a pixel but {image.mode}")
            raw = np.asarray(image)
    except _PNG_ERRORS:
        raise BadMessageError("its PNG is damaged") from None
    return raw.astype(np.uint16)


def _rvl(packed: memoryview) -> NDArray[np.uint16]:
    """Decode RVL to an image (height, width): alternating runs of zeros and differences, in groups of three bits.

    The first of a word's eight nibbles is the highest; bit 3 of a nibble means that its number continues.
    """
    if len(packed) < 8:
        raise BadMessageError("its RVL ends early")
    width, height = struct.unpack_from("<2I", packed)
    _check_size(width, height)
    n = width * height
    words = np.frombuffer(packed, "<u4", min((len(packed) - 8) // 4, n + 4), 8)
    nibbles = ((words[:, np.newaxis] >> np.arange(28, -1, -4, dtype=np.uint32)) & 15).astype(np.uint8).reshape(-1)
    last = np.flatnonzero(nibbles < 8)
    first = np.concatenate([[0], last[:-1] + 1]) if len(last) else last
    if not len(last) or int((last - first).max()) >= LONGEST:
        raise BadMessageError("its RVL is damaged")
    numbers = np.zeros(len(last), dtype=np.int32)
    for k in range(LONGEST):
        going = first + k <= last
        numbers[going] |= (nibbles[first[going] + k] & 7).astype(np.int32) << (3 * k)
    at, pixel, runs = 0, 0, []
    while pixel < n:
        if at + 1 >= len(numbers):
            raise BadMessageError("its RVL ends early")
        pixel += int(numbers[at])
        count = int(numbers[at + 1])
        runs.append((at + 2, pixel, count))
        at, pixel = at + 2 + count, pixel + count
    if pixel > n or at > len(numbers):
        raise BadMessageError("its RVL is damaged")
    source, target, counts = np.array(runs, dtype=np.int64).T
    within = np.arange(int(counts.sum())) - np.repeat(np.cumsum(counts) - counts, counts)
    coded = numbers[np.repeat(source, counts) + within]
    out = np.zeros(n, dtype=np.uint16)
    # A difference is stored as 0, −1, 1, −2, …; values continue from the last one before a run of zeros.
    out[np.repeat(target, counts) + within] = np.cumsum((coded >> 1) ^ -(coded & 1), dtype=np.int64).astype(np.uint16)
    return out.reshape(height, width)
