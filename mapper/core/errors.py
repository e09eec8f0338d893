"""The errors of the mapping core: each has a stable code and one clear sentence."""

from __future__ import annotations


class MapperError(Exception):
    """The caller's input cannot be used.

    ``code`` is a stable, dotted, lower-case identifier for programs (``"log.no_scans"``); ``message`` is one
    sentence for people that says what is wrong and where.
    """

    def __init__(self, code: str, message: str) -> None:
        super().__init__(message)
        self.code = code
        self.message = message

    def __reduce__(self) -> tuple[type[MapperError], tuple[str, str]]:
        """Pickle the error with its code: log readers run in a separate process."""
        return (type(self), (self.code, self.message))


class ReadError(MapperError):
    """A log or map file is malformed. The message names the place: line, byte or key."""


class LimitError(MapperError):
    """The input is well formed but larger than :class:`mapper.core.limits.Limits` allows."""


class ConfigError(MapperError):
    """A parameter, a geometry or a pose is impossible: not finite, out of its range, or of a wrong shape."""


class WorkCancelledError(MapperError):
    """The computation was cancelled by its caller; its result is incomplete and must not be used."""
