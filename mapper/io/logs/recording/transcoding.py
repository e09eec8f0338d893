"""Conversion of Foxglove messages in a recording, in any serialisation, to ROS messages."""

from __future__ import annotations

from mapper.io.logs.names import printable
from mapper.io.logs.recording.sink import MessageSink
from mapper.io.logs.ros import foxglove
from mapper.io.logs.ros.foxglove import Transcoder, transcoder
from mapper.io.logs.ros.message_fields import BadMessageError

MOST_NOTES = 20
TF, TF_STATIC = "tf", "tf_static"  #: names of topics of transforms within their namespace


class Transcoding(MessageSink):
    """Passes a recording on to ``sink``; unchanged to a sink that receives messages as recorded.

    Foxglove transforms, on topics of any name, become ``tf`` of their namespace. Those in the messages of a scan or a
    cloud with key k have the key −1 − k, on ``tf`` of the nearest enclosing namespace that has one.
    """

    def __init__(self, sink: MessageSink) -> None:
        self.notes = sink.notes
        self.as_recorded = sink.as_recorded
        self._sink = sink
        self._transcoders: dict[int, Transcoder] = {}
        self._tf_namespaces = {""}
        self._beside: dict[int, str] = {}  #: keyed by scans and clouds: topic of the transforms in them

    @property
    def taken(self) -> int:
        """Number of messages received by the sink."""
        return self._sink.taken

    def channel(self, key: int, topic: str, kind: str, *, cdr: bool, readable: bool = True) -> None:
        """Announce a stream of ROS messages, some of which are Foxglove's."""
        if not (readable and self.foxglove_channel(key, topic, kind, "cdr" if cdr else "ros1")):
            self._transcoders.pop(key, None)
            self._note_tf(topic)
            self._sink.channel(key, topic, kind, cdr=cdr, readable=readable)

    def foxglove_channel(self, key: int, topic: str, kind: str, encoding: str) -> bool:
        """Announce a stream of messages in any encoding, if their schema is a supported one of Foxglove."""
        transcode = None if self.as_recorded else transcoder(topic, kind, encoding)
        if transcode is None:
            return False
        if self._transcoders.get(key) != transcode and len(self.notes) < MOST_NOTES:
            self.notes.append(
                f"{kind} messages in {encoding} on {printable(topic)!s:.100} are read as {transcode.kind}."
            )
        self._transcoders[key] = transcode
        namespace, _, name = topic.rpartition("/")
        if transcode.kind == foxglove.TF and name not in (TF, TF_STATIC):
            topic = f"{namespace}/{TF}"
        self._note_tf(topic)
        self._sink.channel(key, topic, transcode.kind, cdr=True)
        return True

    def published_by(self, key: int, node: str) -> None:
        """Pass on the publisher of a stream."""
        self._sink.published_by(key, node)

    def _note_tf(self, topic: str) -> None:
        namespace, _, name = topic.rpartition("/")
        if name == TF:
            self._tf_namespaces.add(namespace)

    def _announce_beside(self, key: int, topic: str) -> None:
        """Announce the stream of the transforms in a topic's messages, if their topic has changed."""
        namespace = topic.rpartition("/")[0]
        while namespace not in self._tf_namespaces:
            namespace = namespace.rpartition("/")[0]
        if self._beside.get(key) != namespace:
            self._beside[key] = namespace
            self._sink.channel(-1 - key, f"{namespace}/{TF}", foxglove.TF, cdr=True)

    def knows(self, key: int) -> bool:
        """Return whether this stream was announced."""
        return self._sink.knows(key)

    def wants(self, key: int) -> bool:
        """Return whether this stream's messages are used."""
        return self._sink.wants(key)

    def pass_over(self, key: int, count: int) -> None:
        """Count messages that were not read."""
        self._sink.pass_over(key, count)

    def next_file(self) -> None:
        """Continue with another file, with its own stream keys."""
        self._transcoders.clear()
        self._beside.clear()
        self._sink.next_file()

    def take(self, key: int, stamp_ns: int, data: bytes, size: int | None = None) -> None:
        """Process one message."""
        transcode = self._transcoders.get(key)
        if transcode is None or not data:
            self._sink.take(key, stamp_ns, data, size=size)
            return
        try:
            for is_beside, message in transcode.messages(data):
                if is_beside:
                    self._announce_beside(key, transcode.topic)
                self._sink.take(-1 - key if is_beside else key, stamp_ns, message, size=size)
        except BadMessageError:
            self._sink.take(key, stamp_ns, data, size=size)  # refuses and counts it
