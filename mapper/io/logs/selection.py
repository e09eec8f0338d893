"""Selection of sensors and options for reading a log."""

from __future__ import annotations

from dataclasses import dataclass, field

from mapper.sensors.planar.options import PlanarCut


@dataclass(frozen=True, slots=True)
class Selection:
    """Selection of the planar sensors to read.

    ``topics`` names them; without names, those that make one map are read: the lidar with most scans, or else all
    sonars. None reads all sensors. Point clouds and depth images also count as sensors if they are named, or if there
    is no lidar; ``cut`` has the options for extracting scans from them. ``tf`` names the topic of transforms to use, if
    there are several (None: see :mod:`mapper.io.logs.recording.tf_topics`).
    """

    topics: tuple[str, ...] | None = ()
    cut: PlanarCut = field(default_factory=PlanarCut)
    tf: str | None = None

    @staticmethod
    def of(topic: str | None, cut: PlanarCut | None = None, tf: str | None = None) -> Selection:
        """Return the selection of one sensor, or of the default one."""
        return Selection(() if topic is None else (topic,), cut or PlanarCut(), tf)

    def wants(self, topic: str) -> bool:
        """Return whether a sensor may be selected."""
        return not self.topics or self.names(topic)

    def names(self, topic: str) -> bool:
        """Return whether a sensor is named."""
        return _plain(topic) in {_plain(name) for name in self.topics or ()}

    def name_of(self, topic: str) -> str:
        """Return a topic with its suffix, such as the transform topic in ``/points#/tf_gt``."""
        named = next((name for name in self.topics or () if _plain(name) == _plain(topic)), "")
        return topic + "".join(named.partition("#")[1:])


ALL_SENSORS = Selection(None)


def _plain(topic: str) -> str:
    """Return a topic without its leading slash, and without the suffix that distinguishes sensors on it."""
    return topic.lstrip("/").split("#")[0]
