"""Recording of one robot: its planar sensors, its trajectories, the tree of its frames."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

from mapper.core.errors import ConfigError
from mapper.sensors.scan import ScanLog, Topic
from mapper.sensors.streams import CloudStream, ImuStream
from mapper.sensors.timed_poses import TimedPoses


@dataclass(frozen=True, slots=True)
class TransformEdge:
    """Transform of the frame ``child`` in ``parent`` over time, as a log states it.

    ``is_static`` says that it was stated as never changing (tf_static), ``moves`` that it was stated differently at
    different times, ``count`` how often it was stated.
    """

    parent: str
    child: str
    is_static: bool
    moves: bool
    count: int


@dataclass(frozen=True, slots=True)
class RobotLog:
    """A log of one robot: streams, trajectories and transforms.

    ``sensors`` has the planar range sensors that were asked for, by topic, each with its mount and with the poses at
    its stamps; the first is the one to map where nothing else is said. ``trajectories`` has the robot's poses by name,
    as their sources state them: at their own rates, with their own stamps. ``transforms`` is the tree of frames as it
    was read, ``topics`` all that the file holds. ``clouds`` and ``imus`` are the point clouds and the IMUs by topic,
    which are read from the recording when they are asked for. Raises :class:`ConfigError` for a log without a sensor.
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
        """The sensor to map where none is named."""
        return next(iter(self.sensors.values()))

    @property
    def topics(self) -> tuple[Topic, ...]:
        """All that the file holds, the sensors first; empty for formats of one stream."""
        return self.first.topics
