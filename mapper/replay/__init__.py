"""Map of a log at any time with any parameters."""

from mapper.replay.replay import Replay

__all__ = ["Replay"]
