"""Topics of an MCAP file being written."""

from __future__ import annotations

from mcap.writer import Writer

from mapper.io.export import ros2


class Topics:
    """The channels of a file, registered with their first message.

    ``latched`` are the topics kept for late subscribers.
    """

    def __init__(self, writer: Writer, latched: frozenset[str]) -> None:
        self._writer, self._latched = writer, latched
        self._schemas: dict[str, int] = {}
        self._channels: dict[str, int] = {}

    def send(self, topic: str, kind: str, stamp_ns: int, message: bytes) -> None:
        """Write one serialised message of the type ``kind``."""
        if kind not in self._schemas:
            self._schemas[kind] = self._writer.register_schema(kind, "ros2msg", ros2.definition(kind).encode())
        if topic not in self._channels:
            quality = {"offered_qos_profiles": _quality(latched=topic in self._latched)}
            self._channels[topic] = self._writer.register_channel(topic, "cdr", self._schemas[kind], quality)
        self._writer.add_message(self._channels[topic], log_time=stamp_ns, data=message, publish_time=stamp_ns)


def _quality(*, latched: bool) -> str:
    """Return the QoS profile of a topic in rosbag2's notation: numbers, which its older and newer versions read.

    History: the last message if latched, else the last ten; reliable; no deadlines.
    """
    forever = "{sec: 9223372036, nsec: 854775807}"
    return (
        f"- history: 1\n  depth: {1 if latched else 10}\n  reliability: 1\n  durability: {1 if latched else 2}\n"
        f"  deadline: {forever}\n  lifespan: {forever}\n  liveliness: 1\n"
        f"  liveliness_lease_duration: {forever}\n  avoid_ros_namespace_conventions: false\n"
    )
