"""The topics of a camera, by ROS's conventions: an image and its CameraInfo are in one folder (image_pipeline)."""

from __future__ import annotations

_TRANSPORTS = ("/compressedDepth", "/compressed")  #: what image_transport adds to the topic of the image


def topic_folder(topic: str) -> str:
    """Return a topic without its last part: an image and its CameraInfo are in one folder."""
    return topic.rpartition("/")[0]


def camera_info_topic(topic: str) -> str:
    """Return the topic of the CameraInfo of the images on ``topic``, compressed or not."""
    image = next((topic.removesuffix(ending) for ending in _TRANSPORTS if topic.endswith(ending)), topic)
    return f"{topic_folder(image)}/camera_info"
