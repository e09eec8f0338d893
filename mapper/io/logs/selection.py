"""Selection of the sensors and options with which a log is read."""

from __future__ import annotations

from dataclasses import dataclass, field

from mapper.sensors.planar.options import PlanarCut


@dataclass(frozen=True, slots=True)
class Selection:
    """The planar sensors that are read.

    ``topics`` names them; without one, those that make one map by themselves are read: the lidar with most scans, or
    else all sonars. None reads all sensors. Point clouds and depth images are sensors as well, where they are named,
    or where there is no lidar: ``cut`` says how scans are cut out of them. ``tf`` names the topic of transforms that
    are taken, where there are several (None: see :mod:`mapper.io.logs.recording.tf_topics`).
    """

    topics: tuple[str, ...] | None = ()
    cut: PlanarCut = field(default_factory=PlanarCut)
    tf: str | None = None

    @staticmethod
    def of(topic: str | None, cut: PlanarCut | None = None, tf: str | None = None) -> Selection:
        """Return the selection of one sensor, or of none in particular."""
        return Selection(() if topic is None else (topic,), cut or PlanarCut(), tf)

    def wants(self, topic: str) -> bool:
        """Return whether a sensor may be one of those."""
        return not self.topics or self.names(topic)

    def names(self, topic: str) -> bool:
        """Return whether a sensor is named."""
        return _plain(topic) in {_plain(name) for name in self.topics or ()}

    def name_of(self, topic: str) -> str:
        """Return a topic with what is named behind it, as the topic of transforms of ``/points#/tf_gt``."""
        named = next((name for name in self.topics or () if _plain(name) == _plain(topic)), "")
        return topic + "".join(named.partition("#")[1:])


ALL_SENSORS = Selection(None)


def _plain(topic: str) -> str:
    """Return a topic without its first slash, and without what tells sensors that share it apart."""
    return topic.lstrip("/").split("#")[0]
