"""The stream's message about notes."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct


class NotesMessage(Struct, tag_field="type", tag="notes"):
    """Log sessions: a note on the log was written, changed or deleted. Pages then request the notes again."""

    changed_s: Annotated[float, Meta(description="when, seconds since 1970")]


MESSAGES = (NotesMessage,)
