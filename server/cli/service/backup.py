"""``backup`` and ``restore`` copy the data folder of a service into one file and back."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from server.cli.commands import app
from server.cli.common import fail, refusing
from server.library.backup import back_up
from server.library.backup import restore as put_back
from server.settings import Settings

BackupFile = Annotated[Path, typer.Argument(metavar="FILE", help="The backup, a tar file.")]
DataDir = Annotated[
    Path | None, typer.Option("--data-dir", help="Folder of the service's logs. [that of GRIDBLOOM_DATA_DIR]")
]
ELSEWHERE = (
    "Records or logs are kept elsewhere (GRIDBLOOM_DATABASE, GRIDBLOOM_BLOBS): back these up with the tools of their "
    "stores, such as pg_dump and versions of a bucket."
)


def _folder(data_dir: Path | None) -> Path:
    """Return the data folder. Ends the command if it does not contain all data."""
    settings = Settings()
    if settings.database is not None or settings.blobs is not None:
        fail(ELSEWHERE)
    return data_dir or settings.data_dir


@app.command()
def backup(file: BackupFile, data_dir: DataDir = None) -> None:
    """Copy all logs and records of a service, which may be running, into one new file."""
    folder = _folder(data_dir)
    with refusing(folder):
        try:
            size = back_up(folder, file)
        except OSError as error:
            fail(f"{error.filename or file}: {error.strerror or error}.")
    typer.echo(f"{file}: {size / 1e6:.1f} MB of {folder}")


@app.command()
def restore(file: BackupFile, data_dir: DataDir = None) -> None:
    """Put a backup into a data folder that has no records yet, and that no service uses."""
    folder = _folder(data_dir)
    with refusing(file):
        try:
            put_back(file, folder)
        except OSError as error:
            fail(f"{error.filename or folder}: {error.strerror or error}.")
    typer.echo(f"Restored {file} into {folder}.")
