"""Extraction of planar scans from the clouds and depth images of a recording while it is read.

A cloud is processed as soon as tf has provided the pose of its frame on the robot (for a moving frame, at the cloud's
stamp); a depth image as soon as its CameraInfo has arrived. Until then messages are held, at most :data:`HELD_BYTES`;
then, and at the end of the recording, they are processed with what is known.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mapper.core.errors import ConfigError
from mapper.io.logs.recording.stream import Stream
from mapper.io.logs.recording.tf_topics import TfTopics
from mapper.io.logs.recording.timeline import Moments
from mapper.io.logs.ros.camera_topics import topic_folder
from mapper.io.logs.ros.cloud_messages import CLOUD_DECODERS, Cloud, DepthImage, camera_info, depth_image
from mapper.io.logs.ros.message_fields import BadMessageError
from mapper.io.logs.ros.ros_messages import Beams
from mapper.io.logs.selection import Selection
from mapper.sensors.camera import Intrinsics
from mapper.sensors.planar.cloud import NOT_PLACED, Placement, add_points, empty_scan, first_beam
from mapper.sensors.planar.depth import cut_depth
from mapper.sensors.planar.sweep import SAMPLE, sweep_of

IMAGE, CAMERA = "sensor_msgs/Image", "sensor_msgs/CameraInfo"
HELD_BYTES = 64 << 20
LONGEST_S = 1.0  #: a turn of a lidar; times of points that make it longer are in another unit
FLOOR_CLOUDS = 20  #: number of a topic's first clouds in which the floor is searched
FLOOR_M = 0.1  #: metres above the minimum height in which the floor is searched, and by which it shortens a beam

Emit = Callable[[Stream, int, Beams, int], None]


@dataclass(slots=True)
class Low:
    """Beams of a topic's first clouds: those with a measurement, and those shortened by low points."""

    clouds: int = 0
    measured: int = 0
    shorter: int = 0

    @property
    def share(self) -> float:
        """Fraction of the beams that end at a point less than :data:`FLOOR_M` above the minimum height."""
        return self.shorter / self.measured if self.measured else 0.0


@dataclass(slots=True)
class _Held:
    stream: Stream
    recorded_ns: int
    message: Cloud | DepthImage
    size: int
    number: int  #: index of the message in its stream, from 1
    position: int  #: index of the message in the recording


class Cutter:
    """Extracts scans from clouds and images, and passes them to ``emit`` with stream, recording time and message index.

    ``tf`` and ``children`` are those of the recording, and grow while it is read.
    """

    def __init__(self, selection: Selection, tf: TfTopics, children: set[str], emit: Emit) -> None:
        self.position = 0  #: index of the current message
        self._placements: dict[tuple[str, str], Placement] = {}  #: of static frames, by topic and frame
        self.unplaced: set[str] = set()  #: frames unknown to tf when their first cloud was processed
        self.low: dict[str, Low] = {}  #: by topic
        self.heights: dict[str, tuple[float, float]] = {}  #: of the points of topics whose clouds made no beam, metres
        self._with_beams: set[str] = set()  #: the other topics
        self._cut, self._named = selection.cut, selection.name_of
        self._tf, self._children, self._emit = tf, children, emit
        self._statics = 0  #: number of static transforms when the placements were computed
        self._cameras: dict[str, Intrinsics] = {}  #: by the namespace of their topic
        self._held: list[_Held] = []
        self._held_bytes = 0

    def take_cloud(self, stream: Stream, recorded_ns: int, data: bytes) -> None:
        """Process a cloud of one of the types :data:`CLOUD_DECODERS`. Raises :class:`BadMessageError`."""
        cloud = CLOUD_DECODERS[stream.kind](data, cdr=stream.cdr)
        self._take(_Held(stream, recorded_ns, cloud, len(data), stream.count, self.position))

    def take_image(self, stream: Stream, recorded_ns: int, data: bytes) -> None:
        """Process a sensor_msgs/Image. Raises :class:`BadMessageError`, and ``NotDepthError`` for a picture."""
        image = depth_image(data, cdr=stream.cdr)
        self._take(_Held(stream, recorded_ns, image, len(data), stream.count, self.position))

    def take_camera(self, stream: Stream, _: int, data: bytes) -> None:
        """Process a sensor_msgs/CameraInfo for all images in its namespace. Raises :class:`BadMessageError`."""
        self._cameras[topic_folder(stream.topic)] = camera_info(data, cdr=stream.cdr).intrinsics
        self._cut_held()

    def finish(self) -> None:
        """Process the held messages with what is known now. An image without a CameraInfo counts as unreadable."""
        waiting, self._held, self._held_bytes = self._held, [], 0
        for cloud in waiting:
            try:
                self._cut_one(cloud)
            except BadMessageError as error:
                cloud.stream.refuse(str(error), cloud.number)

    def _take(self, cloud: _Held) -> None:
        waits = any(held.stream is cloud.stream for held in self._held)
        if not waits and self._is_ready(cloud.message, cloud.stream):
            self._cut_one(cloud)
            return
        self._held.append(cloud)
        self._held_bytes += cloud.size
        self._cut_held()
        if self._held_bytes > HELD_BYTES:
            self.finish()

    def _cut_held(self) -> None:
        """Process what is possible so far, each stream in recording order."""
        held, self._held = self._held, []
        waiting: set[int] = set()  #: streams, by their ids
        for cloud in held:
            if id(cloud.stream) in waiting or not self._is_ready(cloud.message, cloud.stream):
                waiting.add(id(cloud.stream))
                self._held.append(cloud)
                continue
            self._held_bytes -= cloud.size
            try:
                self._cut_one(cloud)
            except BadMessageError as error:
                cloud.stream.refuse(str(error), cloud.number)

    def _is_ready(self, message: Cloud | DepthImage, stream: Stream) -> bool:
        if isinstance(message, DepthImage):
            return topic_folder(stream.topic) in self._cameras
        if (stream.topic, message.frame) in self._placements:
            return True
        tf = self._tf.tree_of(self._named(stream.topic), message.frame)
        base = tf.base_of(message.frame, self._children)
        return tf.is_base(base, self._children) and tf.reaches(message.frame, base, message.stamp_ns)

    def _cut_one(self, cloud: _Held) -> None:
        if isinstance(cloud.message, Cloud):
            beams = self._beams_of_cloud(cloud.message, cloud.stream.topic, cloud.position)
        else:
            beams = self._beams_of_image(cloud.message, cloud.stream.topic)
        self._emit(cloud.stream, cloud.recorded_ns, beams, cloud.position)

    def _beams_of_cloud(self, cloud: Cloud, topic: str, position: int) -> Beams:
        cut = self._cut
        placement = self._placement(cloud, topic, position)
        ranges = empty_scan(cut)
        for points in cloud.parts():
            add_points(points, placement, cut, ranges)
        self._look_for_floor(cloud, topic, placement, ranges)
        self._note_heights(cloud, topic, placement, ranges)
        least, greatest = cut.cloud_range
        first, step, mount = first_beam(cut), cut.angle_increment, placement.mount
        begin, increment = self._sweep(cloud, placement)
        stamp_ns = cloud.stamp_ns + round(begin * 1e9)
        return Beams(stamp_ns, cloud.frame, first, step, least, greatest, ranges, time_increment=increment, mount=mount)

    def _sweep(self, cloud: Cloud, placement: Placement) -> tuple[float, float]:
        """Return the time of the first beam, seconds after the stamp, and the time between beams; 0 if not known."""
        timed = cloud.timed_sample(SAMPLE) if cloud.stamp_ns else None
        found = None if timed is None else sweep_of(*timed, placement, self._cut)
        if found is None or abs(found[0]) > LONGEST_S or abs(found[1]) * self._cut.n_beams > LONGEST_S:
            return 0.0, 0.0
        return found

    def _note_heights(self, cloud: Cloud, topic: str, placement: Placement, ranges: NDArray[np.float32]) -> None:
        """Note the heights of the points of a topic in the base frame until one of its clouds makes a beam."""
        if topic in self._with_beams:
            return
        if np.isfinite(ranges).any():
            self._with_beams.add(topic)
            self.heights.pop(topic, None)
            return
        low, high = self.heights.get(topic, (np.inf, -np.inf))
        for points in cloud.parts():
            heights = points @ placement.rotation[2] + placement.translation[2]
            finite = heights[np.isfinite(heights)]
            if len(finite):
                low, high = min(low, float(finite.min())), max(high, float(finite.max()))
        self.heights[topic] = (low, high)

    def _look_for_floor(self, cloud: Cloud, topic: str, placement: Placement, ranges: NDArray[np.float32]) -> None:
        """Count the beams that are longer in the scan above the lowest :data:`FLOOR_M` of the valid heights."""
        low = self.low.setdefault(topic, Low())
        above = self._cut.min_height + FLOOR_M
        if low.clouds >= FLOOR_CLOUDS or above >= self._cut.max_height:
            return
        low.clouds += 1
        cut = replace(self._cut, min_height=above)
        higher = empty_scan(cut)
        for points in cloud.parts():
            add_points(points, placement, cut, higher)
        low.measured += int(np.count_nonzero(np.isfinite(ranges)))
        low.shorter += int(np.count_nonzero(np.isfinite(higher) & (higher > ranges + FLOOR_M)))

    def _placement(self, cloud: Cloud, topic: str, position: int) -> Placement:
        """Return the pose of a cloud's frame on the robot at its stamp."""
        key = (topic, cloud.frame)
        if self._statics != self._tf.statics:  # one may have been replaced
            self._statics = self._tf.statics
            self._placements = {
                known: placement for known, placement in self._placements.items() if placement is NOT_PLACED
            }
        placement = self._placements.get(key)
        if placement is not None:
            return placement
        tf = self._tf.tree_of(self._named(topic), cloud.frame)
        base = tf.base_of(cloud.frame, self._children)
        poses = None
        if base != cloud.frame:
            poses = tf.relative(cloud.frame, base, Moments(np.array([cloud.stamp_ns]), np.array([position])))
        if poses is None:
            if not tf.is_base(base, self._children):
                self.unplaced.add(cloud.frame)
            self._placements[key] = NOT_PLACED
            return NOT_PLACED
        placement = Placement(poses.matrices[0], poses.positions[0])
        if tf.is_fixed(cloud.frame, base):
            self._placements[key] = placement
        return placement

    def _beams_of_image(self, image: DepthImage, topic: str) -> Beams:
        camera = self._cameras.get(topic_folder(topic))
        if camera is None:
            raise BadMessageError(f"no CameraInfo has come on {topic_folder(topic)}/camera_info")
        try:
            ranges = cut_depth(image.metres(), camera, self._cut)
        except ConfigError as error:
            raise BadMessageError(error.message) from None
        first, step = camera.beams()
        least, greatest = self._cut.depth_range
        frame = self._cut.output_frame or image.frame
        # A beam covers the columns from its bearing to the next one's, so its bearing is stated in their middle.
        return Beams(image.stamp_ns, frame, first + 0.5 * step, step, least, greatest, ranges)


def is_forward(up: NDArray[np.float64]) -> bool:
    """Return whether a camera's frame has its z axis along the viewing direction, given z components (n,) of its z
    axis.

    This is so for optical frames (REP 103); some drivers publish depth images in a frame with the x axis along the
    view.
    """
    return bool(abs(float(up[0])) < 0.9)
