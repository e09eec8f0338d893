"""A check of the stores of a library before a server uses them."""

from __future__ import annotations

from pathlib import Path

from server.jobs.workers import worker_at
from server.library.processing.fleet.cluster import require_dask
from server.library.store.blobs import Blobs
from server.library.store.revision import refuse_newer_file
from server.settings import Settings
from server.storage import RECORDS_FILE, private_folder

SQLITE = "sqlite:///"  #: prefix of the URL of a file


def check_stores(settings: Settings) -> None:
    """Open the stores of a library, upgrade them and close them. Raises :class:`StorageError`."""
    from server.library.store.database import Database  # noqa: PLC0415
    from server.library.store.identity import check_store_identity  # noqa: PLC0415 - who reads logs does without SQLAlchemy

    root = settings.data_dir / "library"
    url = settings.database_url or f"{SQLITE}{root / RECORDS_FILE}"
    file = Path(url.removeprefix(SQLITE))
    if url.startswith(SQLITE) and file.is_file():
        refuse_newer_file(file)
    private_folder(root)
    blobs = Blobs.at(settings.blobs, root)
    database = Database.open(settings.database_url, root)
    try:
        check_store_identity(database, blobs)
    finally:
        database.close()
    if settings.executor is not None:
        worker_at(settings.executor, 0, root).close()
    if settings.fleet_executor is not None:  # it need not be available yet
        require_dask()
