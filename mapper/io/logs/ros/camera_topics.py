"""Topics of a camera by ROS's conventions: an image and its CameraInfo share a namespace (image_pipeline)."""

from __future__ import annotations

_TRANSPORTS = ("/compressedDepth", "/compressed")  #: suffixes added by image_transport to the image topic


def topic_folder(topic: str) -> str:
    """Return a topic without its last part, the namespace shared by an image and its CameraInfo."""
    return topic.rpartition("/")[0]


def camera_info_topic(topic: str) -> str:
    """Return the topic of the CameraInfo of the images on ``topic``, compressed or not."""
    return f"{topic_folder(_image_topic(topic))}/camera_info"


def is_rectified(topic: str) -> bool:
    """Return whether the images on ``topic`` are rectified: image_rect, image_rect_color, image_rect_raw."""
    return "rect" in _image_topic(topic).rpartition("/")[2].split("_")


def _image_topic(topic: str) -> str:
    return next((topic.removesuffix(ending) for ending in _TRANSPORTS if topic.endswith(ending)), topic)
