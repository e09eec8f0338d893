"""Errors where a visitor may not open or change a log."""

from __future__ import annotations

from mapper.core.errors import MapperError


class LogNotFoundError(MapperError):
    """There is no such log for this visitor: it never existed, was deleted, or belongs to another visitor."""


class LogReadOnlyError(MapperError):
    """The log is not the visitor's to delete."""
