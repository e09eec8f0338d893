"""The playback of a session: whether it plays, and its speed."""

from __future__ import annotations

from dataclasses import dataclass

from server.stream.protocol import ProtocolError


@dataclass(slots=True)
class Playback:
    """Whether a session plays; ``speed`` is seconds of its time per second, within ``speeds``."""

    playing: bool = True
    speed: float = 1.0
    speeds: tuple[float, float] = (0.25, 8.0)  #: the least and the greatest speed

    def set_speed(self, speed: float) -> None:
        """Set the speed. Raises :class:`ProtocolError` for one outside ``speeds``."""
        low, high = self.speeds
        if not low <= speed <= high:
            raise ProtocolError("command.value", f"The speed must be between {low:g} and {high:g}.")
        self.speed = speed
