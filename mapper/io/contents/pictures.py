"""Small picture of one image or point cloud of a recording.

Source: sensor_msgs/image_encodings.h (the encodings), sensor_msgs/CompressedImage. Pillow decodes JPEG and PNG. To be
run in a process with limits, because the data is untrusted.
"""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import LimitError, ReadError
from mapper.core.sampling import sample_rows
from mapper.io.logs.ros.cloud_messages import point_cloud
from mapper.io.logs.ros.message_fields import BadMessageError, MessageFields

if TYPE_CHECKING:
    from PIL.Image import Image

MAX_PIXELS = 1 << 26  #: of one image: more than any robot's camera has
SIDE = 640  #: maximum side of a picture in pixels
CLOUD_SIDE = 480  #: pixels of a cloud's picture
JPEG_QUALITY = 80

#: Encoding → numpy type, channels, and indices of red, green and blue (None: grey).
PLAIN: dict[str, tuple[str, int, tuple[int, int, int] | None]] = {
    "rgb8": ("u1", 3, (0, 1, 2)),
    "bgr8": ("u1", 3, (2, 1, 0)),
    "rgba8": ("u1", 4, (0, 1, 2)),
    "bgra8": ("u1", 4, (2, 1, 0)),
    "8UC3": ("u1", 3, (2, 1, 0)),
    "mono8": ("u1", 1, None),
    "8UC1": ("u1", 1, None),
    "mono16": ("u2", 1, None),
    "16UC1": ("u2", 1, None),
    "32FC1": ("f4", 1, None),
}
#: Positions of red, of both greens and of blue in each 2 × 2 pixels of a Bayer pattern, by row and column.
BAYER: dict[str, str] = {
    "bayer_rggb8": "rggb",
    "bayer_bggr8": "bggr",
    "bayer_gbrg8": "gbrg",
    "bayer_grbg8": "grbg",
}
#: Encoding → whether the luminance is first in each pair of bytes.
YUV: dict[str, bool] = {"yuv422": False, "yuv422_yuy2": True, "uyvy": False, "yuyv": True}


def picture_of(kind: str, data: bytes, *, cdr: bool) -> tuple[bytes, str]:
    """Return a message of type ``kind`` as a picture of at most :data:`SIDE` pixels per side, and its media type.

    Raises :class:`LimitError` for an image of implausible size, and :class:`ReadError` for one that cannot be decoded.
    """
    try:
        return _DRAWN[kind](data, cdr=cdr)
    except BadMessageError as error:
        reason = f": {error}" if str(error) else ""
        raise ReadError("picture.damaged", f"The message is no {kind} that can be read{reason}.") from None


def _image(data: bytes, *, cdr: bool) -> tuple[bytes, str]:
    fields = MessageFields(data, cdr=cdr)
    fields.header()
    height, width = (int(n) for n in fields.unpack("2I", 4))
    encoding = fields.string()
    (is_bigendian,) = fields.unpack("B", 1)
    (step,) = (int(n) for n in fields.unpack("I", 4))
    values = fields.bytes()
    fields.end()
    _check_size(width, height)
    if encoding in PLAIN:
        code, channels, colours = PLAIN[encoding]
        kind = np.dtype((">" if is_bigendian else "<") + code)
        pixels = _rows(values, height, width * channels, step, kind).reshape(height, width, channels)
        small = _thinned(pixels)
        shown = _grey(small[:, :, 0]) if colours is None else np.ascontiguousarray(small[:, :, list(colours)])
    elif encoding in BAYER:
        shown = _thinned(_bayer(_rows(values, height, width, step, np.dtype("u1")), BAYER[encoding]))
    elif encoding in YUV:
        pairs = _rows(values, height, 2 * width, step, np.dtype("u1")).reshape(height, width, 2)
        shown = _grey(_thinned(pairs)[:, :, 0 if YUV[encoding] else 1])
    else:
        raise ReadError("picture.encoding", f"Images of the encoding {encoding!r:.60} are not shown.")
    from PIL import Image as Pillow  # noqa: PLC0415 - only who decodes a picture needs it

    return _jpeg(Pillow.fromarray(shown))


def _compressed(data: bytes, *, cdr: bool) -> tuple[bytes, str]:
    fields = MessageFields(data, cdr=cdr)
    fields.header()
    fields.string()  # the format, which is detected from the bytes
    values = fields.bytes()
    fields.end()
    from PIL import Image as Pillow  # noqa: PLC0415
    from PIL import UnidentifiedImageError  # noqa: PLC0415

    try:
        with Pillow.open(io.BytesIO(values), formats=("JPEG", "PNG")) as image:
            _check_size(*image.size)
            image.draft("RGB", (SIDE, SIDE))  # a JPEG is decoded at reduced size
            return _jpeg(image if image.mode in ("L", "RGB") else image.convert("RGB"))
    except (UnidentifiedImageError, OSError, SyntaxError, ValueError, Pillow.DecompressionBombError) as error:
        raise ReadError("picture.damaged", "The compressed image is not a JPEG or PNG that can be decoded.") from error


def _cloud(data: bytes, *, cdr: bool) -> tuple[bytes, str]:
    """Draw a cloud from above, x up and y left as seen from behind the robot; lighter is higher."""
    cloud = point_cloud(data, cdr=cdr)
    height, width = cloud.axes[0].shape
    _check_size(width, height)
    share = min(1.0, 400_000 / (height * width))
    parts = (part[sample_rows(len(part), round(share * len(part)))] for part in cloud.parts())
    xyz = np.concatenate([*parts] or [np.zeros((0, 3))])
    xyz = xyz[np.isfinite(xyz).all(axis=1)]
    shown = np.full((CLOUD_SIDE, CLOUD_SIDE), 0, dtype=np.uint8)
    if len(xyz):
        reach = max(1.0, float(np.percentile(np.abs(xyz[:, :2]), 98)))
        pixel = np.floor((1.0 - xyz[:, :2] / reach) * 0.5 * CLOUD_SIDE)
        inside = ((pixel >= 0) & (pixel < CLOUD_SIDE)).all(axis=1)
        low, high = np.percentile(xyz[:, 2], [2, 98])
        shade = np.clip((xyz[:, 2] - low) / max(high - low, 1e-3), 0.0, 1.0)
        rows, cols = pixel[inside].astype(np.intp).T
        np.maximum.at(shown, (rows, cols), (90 + 165 * shade[inside]).astype(np.uint8))
    from PIL import Image as Pillow  # noqa: PLC0415

    out = io.BytesIO()
    Pillow.fromarray(shown).save(out, "PNG")
    return out.getvalue(), "image/png"


#: Each type of :data:`mapper.io.contents.model.PICTURED` → the function that draws one message.
_DRAWN: dict[str, Callable[..., tuple[bytes, str]]] = {
    "sensor_msgs/Image": _image,
    "sensor_msgs/CompressedImage": _compressed,
    "sensor_msgs/PointCloud2": _cloud,
}


def _check_size(width: int, height: int) -> None:
    if width <= 0 or height <= 0:
        raise ReadError("picture.size", f"The message states {width} × {height} pixels, which cannot be a picture.")
    if width * height > MAX_PIXELS:
        raise LimitError(
            "picture.too_large",
            f"The message states {width} × {height} pixels; the limit is {MAX_PIXELS} in all.",
        )


def _rows(values: memoryview, height: int, per_row: int, step: int, kind: np.dtype[np.generic]) -> NDArray[np.generic]:
    """Return the numbers of an image (height, per_row), a view of its bytes."""
    row_bytes = per_row * kind.itemsize
    there = len(values)
    if step < row_bytes or (height - 1) * step + row_bytes > there:
        raise BadMessageError(f"{height} rows of {row_bytes} bytes, {step} apart, do not fit its {there} bytes")
    return np.ndarray((height, per_row), kind, values, 0, (step, kind.itemsize))


def _thinned(pixels: NDArray[np.generic]) -> NDArray[np.generic]:
    """Return every n-th row and column, so that Pillow has at most twice :data:`SIDE` to scale."""
    every = max(1, -(-max(pixels.shape[:2]) // (2 * SIDE)))
    return pixels[::every, ::every]


def _bayer(pixels: NDArray[np.generic], pattern: str) -> NDArray[np.generic]:
    """Return a colour image (rows / 2, columns / 2, 3) of a Bayer pattern, one pixel per 2 × 2 pixels."""
    even = pixels[: pixels.shape[0] // 2 * 2, : pixels.shape[1] // 2 * 2]
    parts = [even[0::2, 0::2], even[0::2, 1::2], even[1::2, 0::2], even[1::2, 1::2]]
    return np.stack([parts[pattern.index(colour)] for colour in "rgb"], axis=-1)


def _grey(values: NDArray[np.generic]) -> NDArray[np.uint8]:
    """Convert to grey: bytes unchanged, other numbers scaled from their 1st to their 99th percentile."""
    if values.dtype == np.uint8:
        return np.ascontiguousarray(values)
    numbers = values.astype(np.float32)
    known = numbers[np.isfinite(numbers) & (numbers != 0.0)]  # 0 is no depth
    if not len(known):
        return np.zeros(values.shape, dtype=np.uint8)
    low, high = np.percentile(known, [1, 99])
    scaled = np.nan_to_num((numbers - low) / max(float(high - low), 1e-9), nan=0.0, posinf=0.0, neginf=0.0)
    return np.asarray(np.clip(scaled, 0.0, 1.0) * 255.0, dtype=np.uint8)


def _jpeg(image: Image) -> tuple[bytes, str]:
    image.thumbnail((SIDE, SIDE))
    out = io.BytesIO()
    image.save(out, "JPEG", quality=JPEG_QUALITY)
    return out.getvalue(), "image/jpeg"
