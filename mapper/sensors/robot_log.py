"""Recording of one robot: planar sensors, trajectories and frame tree."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from mapper.core.errors import ConfigError
from mapper.sensors.scan import ScanLog, Topic
from mapper.sensors.streams import CloudStream, ImuStream
from mapper.sensors.timed_poses import TimedPoses


@dataclass(frozen=True, slots=True)
class TransformEdge:
    """Transform of the frame ``child`` in ``parent`` over time, as stated by a log.

    ``is_static`` means that it was published as constant (tf_static), ``moves`` that its value changed over time;
    ``count`` is the number of messages.
    """

    parent: str
    child: str
    is_static: bool
    moves: bool
    count: int


@dataclass(frozen=True, slots=True)
class RobotLog:
    """A log of one robot: streams, trajectories and transforms.

    ``sensors`` has the requested planar range sensors by topic, each with its mount and with the poses at its stamps;
    the first is mapped by default. ``trajectories`` has the robot's poses by name, with the rates and stamps of their
    sources. ``transforms`` is the frame tree as read, ``topics`` lists all streams of the file. ``clouds`` and ``imus``
    are the point clouds and the IMUs by topic, which are read from the recording on demand. Raises :class:`ConfigError`
    for a log without a sensor.
    """

    sensors: Mapping[str, ScanLog]
    trajectories: Mapping[str, TimedPoses] = field(default_factory=dict)
    transforms: tuple[TransformEdge, ...] = ()
    clouds: Mapping[str, CloudStream] = field(default_factory=dict)
    imus: Mapping[str, ImuStream] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if not self.sensors:
            raise ConfigError("log.no_scans", "A robot’s log needs at least one range sensor.")

    @staticmethod
    def of_one(log: ScanLog) -> RobotLog:
        """Return the log of a robot with one sensor."""
        timed = {
            name: trajectory.timed for name, trajectory in log.trajectories.items() if trajectory.timed is not None
        }
        if log.odometry is not None:
            timed.setdefault("odometry", log.odometry.messages)
        return RobotLog({log.topic: log}, timed)

    @property
    def first(self) -> ScanLog:
        """The sensor that is mapped by default."""
        return next(iter(self.sensors.values()))

    @property
    def topics(self) -> tuple[Topic, ...]:
        """All streams of the file, the sensors first; empty for formats with one stream."""
        return self.first.topics
