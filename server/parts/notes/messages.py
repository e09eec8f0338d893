"""The message about notes, as the stream has it."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct


class NotesMessage(Struct, tag_field="type", tag="notes"):
    """Log sessions: a note on the log was written, changed or deleted; the page asks for the notes again."""

    changed_s: Annotated[float, Meta(description="when, seconds since 1970")]


MESSAGES = (NotesMessage,)
