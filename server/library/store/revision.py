"""The revision of a database's tables, and the refusal of unknown ones."""

from __future__ import annotations

import contextlib
import logging
import sqlite3
from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING

from server.library.store.migrations import HEAD
from server.storage import StorageError

if TYPE_CHECKING:
    from alembic.config import Config

MIGRATIONS = Path(__file__).parent / "migrations"


def alembic_config() -> Config:
    """Return alembic's configuration with the location of the revisions."""
    logging.getLogger("alembic").setLevel(logging.WARNING)  # do not log each plugin and each step
    from alembic.config import Config  # noqa: PLC0415 - start-up: mostly the revision is the newest

    config = Config()
    config.set_main_option("script_location", str(MIGRATIONS).replace("%", "%%"))
    return config


def known_revisions() -> Collection[str]:
    """Return all revisions that this program can upgrade."""
    config = alembic_config()
    from alembic.script import ScriptDirectory  # noqa: PLC0415 - start-up: as above

    return {script.revision for script in ScriptDirectory.from_config(config).walk_revisions()}


def refuse_unknown(version: str | None) -> None:
    """Raise :class:`StorageError` for an unknown revision, and for None."""
    if version != HEAD and version not in known_revisions():
        raise StorageError(
            "library.newer",
            f"The records were written by a newer Gridbloom, or by one from before version 0.2 (their revision is "
            f"{version or 'unknown'}, this one knows {HEAD}): install that one, or choose another database.",
        )


def refuse_newer_file(file: Path) -> None:
    """Raise :class:`StorageError` for an SQLite file with unknown tables. Neither it nor its journal is changed.

    A journal (``-wal``) without its index (``-shm``) gets one, which remains, because another program may be using it
    by then. An unreadable file is left to those who open it.
    """
    journal = file.with_name(f"{file.name}-wal")
    # Without a journal the file is complete; with one SQLite needs its index, which it creates if it is missing.
    is_whole = not journal.exists() or journal.stat().st_size == 0
    place = f"{file.absolute().as_uri()}?mode=ro{'&immutable=1' if is_whole else ''}"
    version: tuple[str] | None = (HEAD,)
    with contextlib.suppress(sqlite3.Error), contextlib.closing(sqlite3.connect(place, uri=True)) as records:
        version = records.execute("SELECT version_num FROM alembic_version").fetchone()
    refuse_unknown(None if version is None else version[0])
