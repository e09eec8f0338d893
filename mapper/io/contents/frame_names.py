"""Coordinate frames named in a message.

Source: std_msgs/Header, and the definitions of the messages that start with one, in ROS 1 and ROS 2.
"""

from __future__ import annotations

from collections.abc import Iterator

from mapper.io.contents.tree_values import Tree
from mapper.io.logs.names import printable
from mapper.io.logs.ros.message_fields import BadMessageError, MessageFields

MAX_FRAMES = 50  #: names of one message
MAX_NAME = 200  #: characters of a name
_NAMES = frozenset(("frame_id", "child_frame_id", "parent_frame_id"))  #: the last one in Foxglove

#: Types that start with a Header, for recordings without definitions.
HEADED = frozenset(
    f"{package}/{name}"
    for package, names in {
        "sensor_msgs": "BatteryState CameraInfo CompressedImage FluidPressure Illuminance Image Imu JointState Joy "
        "LaserScan MagneticField MultiDOFJointState MultiEchoLaserScan NavSatFix PointCloud PointCloud2 Range "
        "RelativeHumidity Temperature TimeReference",
        "nav_msgs": "GridCells OccupancyGrid Odometry Path",
        "geometry_msgs": "AccelStamped AccelWithCovarianceStamped InertiaStamped PointStamped PolygonStamped PoseArray "
        "PoseStamped PoseWithCovarianceStamped QuaternionStamped TransformStamped TwistStamped "
        "TwistWithCovarianceStamped Vector3Stamped WrenchStamped",
        "visualization_msgs": "ImageMarker Marker",
    }.items()
    for name in names.split()
)
#: Those followed by the name of a child frame.
_WITH_CHILD = frozenset(("nav_msgs/Odometry", "geometry_msgs/TransformStamped"))


def frames_in(tree: Tree) -> tuple[str, ...]:
    """Return the frames named in a message's fields :data:`_NAMES`, at any depth."""
    return _named(_values(tree))


def frames_of_type(kind: str, data: bytes, *, cdr: bool) -> tuple[str, ...]:
    """Return the frames at the start of a message of a type in :data:`HEADED`; none for other types."""
    if kind not in HEADED:
        return ()
    fields = MessageFields(data, cdr=cdr)
    try:
        _, frame = fields.header()
        return _named(iter((frame, fields.frame() if kind in _WITH_CHILD else "")))
    except BadMessageError:
        return ()


def _named(names: Iterator[str]) -> tuple[str, ...]:
    named: dict[str, None] = {}  # used as an ordered set
    for name in names:
        if len(named) == MAX_FRAMES:
            break
        if frame := printable(name[:MAX_NAME]).lstrip("/"):
            named[frame] = None
    return tuple(named)


def _values(value: object) -> Iterator[str]:
    if isinstance(value, dict):
        for name, part in value.items():
            if name in _NAMES and isinstance(part, str):
                yield part
            else:
                yield from _values(part)
    elif isinstance(value, list):
        for part in value:
            yield from _values(part)
