"""The picture of a depth image."""

from __future__ import annotations

import io

import numpy as np

from mapper.core.array_types import Float32Array

DARKEST = 40  #: grey of what is as far as the camera reaches; 0 is where nothing returned


def depth_png(depths: Float32Array, reach: float) -> bytes:
    """Return ``depths`` (rows, cols), metres, 0 for none, as PNG: the nearer the lighter, up to ``reach`` metres."""
    from PIL import Image  # noqa: PLC0415 - start-up

    near = 1.0 - np.clip(depths / reach, 0.0, 1.0)
    grey = np.where(depths > 0.0, DARKEST + (255 - DARKEST) * near, 0.0)
    file = io.BytesIO()
    Image.fromarray(np.round(grey).astype(np.uint8)).save(file, "PNG")
    return file.getvalue()
