"""Topics of tf in a recording, and selection of the one for a sensor's frame.

Robots of one recording may have the same frames, each on its own topics: nodes look frames up in ``tf`` of their own
namespace (Nav2 and others remap ``/tf`` to ``tf``). So a sensor's frames are those of ``tf`` and ``tf_static`` in the
namespace of its topic, or in the nearest enclosing one, up to ``/tf``; only if there is none, in another topic of
transforms that has its frame. The transforms of two topics are never merged into one tree.
"""

from __future__ import annotations

from dataclasses import dataclass

from mapper.core.errors import ReadError
from mapper.core.limits import Limits
from mapper.io.logs.recording.runs import Track
from mapper.io.logs.recording.timeline import Timeline
from mapper.io.logs.recording.transforms import FrameTree, Stated
from mapper.io.logs.ros.ros_messages import StampedPose

SECOND = " (2)"  #: behind the name of a frame: that of the second of two programs that state it
STATIC = "_static"  #: suffix of topics of static transforms


def is_static(topic: str) -> bool:
    """Return whether the transforms on a topic are static, by its name: ``tf_static``, ``tf_gt_static``."""
    return topic.rsplit("/", 1)[-1].endswith(STATIC)


def namespaces(topic: str) -> list[str]:
    """Return the namespace of a topic and the enclosing ones: ``/a/b``, ``/a`` and nothing, for ``/a/b/scan``."""
    parts = topic.strip("/").split("/")[:-1]
    return ["".join(f"/{part}" for part in parts[:n]) for n in range(len(parts), -1, -1)]


def in_tf(sensor: str, topic: str) -> str:
    """Return the name of a sensor whose frames are looked up in a topic's transforms, if there are several."""
    return f"{sensor}#{topic}"


@dataclass(frozen=True, slots=True)
class Choice:
    """The topics of a sensor's transforms, empty if there are none; ``others`` are alternatives."""

    moving: str
    static: str
    others: tuple[str, ...] = ()


class TfTopics:
    """The transforms of a recording by topic. ``wanted`` names the topic for all sensors."""

    def __init__(self, limits: Limits, wanted: str | None = None) -> None:
        self._limits, self._wanted = limits, wanted
        self._stated: dict[str, Stated] = {}
        self._chosen: dict[tuple[str, str], Choice] = {}
        self.statics = 0  #: number of static transforms, without repetitions
        self._nothing = Stated()

    def add(self, topic: str, transform: StampedPose, position: int, recorded_ns: int = 0) -> str:
        """Add one transform of the message with index ``position``, recorded at ``recorded_ns``, on a topic.

        See :meth:`FrameTree.add`.
        """
        stated = self._stated.setdefault(topic, Stated())
        before, statics = stated.edges, stated.statics
        ignored = stated.add(
            transform, self._limits, is_static=is_static(topic), position=position, recorded_ns=recorded_ns
        )
        if stated.edges != before:
            self._chosen.clear()
        self.statics += stated.statics - statics
        return ignored

    @property
    def moving(self) -> list[str]:
        """The topics of non-static transforms."""
        return [topic for topic in self._stated if not is_static(topic)]

    @property
    def timelines(self) -> list[tuple[str, Timeline]]:
        """The transforms of each pair of frames that are not static, with their topics."""
        lines = ((topic, each.values()) for topic, tree in self._stated.items() for each in tree.moving.values())
        return [(topic, line) for topic, each in lines for line in each]

    def part_senders(self) -> list[str]:
        """Give what two senders state in turns of one frame in another to two parents; return a note on each.

        The second parent has the name of the first and a number behind it.
        """
        notes = []
        for topic, tree in self._stated.items():
            for child, parents in tree.moving.items():
                for parent, line in list(parents.items()):
                    parted = line.by_sender()
                    if parted is None:
                        continue
                    other = f"{parent}{SECOND}"
                    parents[parent], parents[other] = parted
                    tree.children.setdefault(other, {})[child] = None
                    notes.append(
                        f"Two programs state on {topic} where {child!r:.100} is in {parent!r:.100}, in turns "
                        f"({len(parents[parent])} and {len(parents[other])} transforms), and tf2 jumps between them. "
                        f"What follows from each is a trajectory of its own; the second is in {other!r:.100}. Let one "
                        "of them state it."
                    )
        return notes

    @property
    def static_tracks(self) -> list[Track]:
        """The stamps of the static transforms of each frame of each topic."""
        return [Track(topic, *line.track) for topic, tree in self._stated.items() for line in tree.static.values()]

    def put_statics_in_order(self) -> None:
        """Position the static transforms by recording time, not by their place in the file."""
        for tree in self._stated.values():
            for line in tree.static.values():
                line.put_in_order()

    def tree_of(self, sensor: str, frame: str) -> FrameTree:
        """Return the transforms for the ``frame`` of the messages on a topic."""
        choice = self.choice(sensor, frame)
        return self.tree_with(choice.moving, choice.static)

    def tree_with(self, moving: str, static: str) -> FrameTree:
        """Return the transforms of a topic together with the static ones of another."""
        return FrameTree(self._limits, self._stated.get(moving, self._nothing), self._stated.get(static, self._nothing))

    def choice(self, sensor: str, frame: str) -> Choice:
        """Return the topics of transforms for the ``frame`` of the messages on a topic."""
        key = (sensor, frame)
        if key not in self._chosen:
            name, *parts = sensor.split("#")
            named = (self._known(topic) for topic in (*parts[-1:], self._wanted or ""))
            self._chosen[key] = self._choose(name, frame, next(filter(None, named), None))
        return self._chosen[key]

    def _choose(self, sensor: str, frame: str, named: str | None) -> Choice:
        moving = named or self._moving_of(sensor, frame)
        static = self._static_of(sensor, moving, frame)
        own = set(self._frames(moving))
        others = [
            topic
            for topic in self.moving
            if topic != moving and (topic in self._named(sensor, "tf") or own & set(self._frames(topic)))
        ]
        around, own_space = namespaces(sensor), namespaces(moving)[0]
        if own_space and own_space in around:  # transforms outside that namespace are other robots'
            spaces = {topic: namespaces(topic)[0] for topic in others}
            others = [other for other in others if spaces[other] in around or spaces[other].startswith(f"{own_space}/")]
        return Choice(moving, static, tuple(others))

    def _frames(self, topic: str) -> list[str]:
        stated = self._stated.get(topic)
        return [] if stated is None else list(stated.moving)

    def _named(self, topic: str, name: str) -> list[str]:
        """Return the topics with a name in the namespace of another topic and the enclosing ones, nearest first."""
        names = {known.strip("/"): known for known in self._stated}
        candidates = (f"{space}/{name}".strip("/") for space in namespaces(topic))
        return [names[name] for name in candidates if name in names]

    def _moving_of(self, sensor: str, frame: str) -> str:
        near = self._named(sensor, "tf")
        for topic in near:
            static = self._stated.get(self._static_of(sensor, topic, frame), self._nothing)
            if self._stated[topic].knows(frame) or static.knows(frame):
                return topic
        if near:
            return near[0]
        known = [topic for topic in self.moving if self._stated[topic].knows(frame)]
        return max(known or self.moving, key=self._count, default="")

    def _count(self, topic: str) -> int:
        return sum(len(line) for lines in self._stated[topic].moving.values() for line in lines.values())

    def _static_of(self, sensor: str, moving: str, frame: str) -> str:
        """Return the topic of static transforms that belongs to a topic of others, or else to the sensor."""
        statics = [topic for topic in self._stated if is_static(topic)]
        pair = [topic for topic in statics if moving and topic.strip("/") == moving.strip("/") + STATIC]
        near = [*self._named(sensor, f"tf{STATIC}"), *(self._named(moving, f"tf{STATIC}") if moving else [])]
        if namespaces(sensor)[0] and not pair:
            pair = near[:1]
        candidates = dict.fromkeys([*pair, *near, *(statics if len(statics) == 1 else [])])
        return next((topic for topic in candidates if self._stated[topic].knows(frame)), next(iter(candidates), ""))

    @property
    def is_chosen(self) -> bool:
        """Whether one topic was named for all sensors."""
        return self._wanted is not None

    def check(self) -> None:
        """Raise :class:`ReadError` if the recording has no transforms on the topic named for all."""
        if self._wanted is not None and self._known(self._wanted) is None:
            known = ", ".join(self.moving[:6]) or "none"
            raise ReadError("log.tf", f"The log has no transforms on {self._wanted!r:.80}; it has {known:.400}.")

    def _known(self, topic: str) -> str | None:
        """Return the topic of non-static transforms of that name, with or without its leading slash."""
        return next((topic_ for topic_ in self.moving if topic_.strip("/") == topic.strip("/")), None)
