"""``serve`` runs the service, ``backup`` and ``restore`` copy its data folder into one file and back.

``upload`` sends a log to a service; ``notes`` writes the notes on a log of one to a file.
"""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from mapper.core.errors import MapperError
from server.cli.common import AsJson, app, fail, print_json, print_notes, progress_bar, refusing
from server.imports import fast_imports

if TYPE_CHECKING:
    from server.client import NoteFile

#: Kinds of files of notes by their ending.
NOTE_FILES: dict[str, NoteFile] = {".geojson": "geojson", ".json": "geojson", ".csv": "csv"}
BackupFile = Annotated[Path, typer.Argument(metavar="FILE", help="The backup, a tar file.")]
DataDir = Annotated[
    Path | None, typer.Option("--data-dir", help="Folder of the service's logs. [that of GRIDBLOOM_DATA_DIR]")
]
ELSEWHERE = (
    "Records or logs are kept elsewhere (GRIDBLOOM_DATABASE, GRIDBLOOM_BLOBS): back these up by the means of their "
    "stores, such as pg_dump and versions of a bucket."
)


@app.command()
def serve(
    host: Annotated[str | None, typer.Option(help="Address to listen on. [127.0.0.1]")] = None,
    port: Annotated[int | None, typer.Option(help="Port to listen on; 0 chooses a free one. [8000]")] = None,
    data_dir: Annotated[
        Path | None,
        typer.Option(
            readable=False,  # it may not exist yet, and what is wrong with it is said below
            help="Folder for uploaded logs. [gridbloom in the folder XDG_DATA_HOME, by default ~/.local/share]",
        ),
    ] = None,
    blobs: Annotated[str | None, typer.Option(help="Store of the logs' files: a folder or s3://BUCKET/PREFIX.")] = None,
    database: Annotated[
        str | None, typer.Option(help="Database of the logs' records, sqlite:/// or postgresql://.")
    ] = None,
    logs_dir: Annotated[Path | None, typer.Option(help="Folder of logs that all visitors see, read-only.")] = None,
    fleet_executor: Annotated[
        str | None,
        typer.Option(
            help="Scheduler of the Dask cluster on which the page maps all logs, tcp://HOST:PORT or tls://HOST:PORT."
        ),
    ] = None,
    workers: Annotated[
        str | None,
        typer.Option(
            help="Number of processes that have the sessions, or auto: one for each of more than two cores. [1]"
        ),
    ] = None,
    open_class: Annotated[
        bool,
        typer.Option(
            "--class",
            help="Open a class, and print its address as a QR code; listens on all addresses unless --host is given.",
        ),
    ] = False,
    no_token: Annotated[
        bool, typer.Option("--no-token", help="Require no token although other machines can reach the service.")
    ] = False,
) -> None:
    """Run the service. Every option can also be set in the environment, for example GRIDBLOOM_PORT."""
    with fast_imports():
        from pydantic import ValidationError  # noqa: PLC0415 - start-up

        from server.serving import run  # noqa: PLC0415 - start-up
        from server.settings import Settings, unknown_setting  # noqa: PLC0415 - start-up

    if unknown := unknown_setting(os.environ):
        fail(unknown)
    if open_class:
        from server.classes.codes import new_code  # noqa: PLC0415 - few start with a class

        host = host or "0.0.0.0"  # noqa: S104 - the hall's network is meant
    options: dict[str, Any] = {
        "host": host,
        "port": port,
        "data_dir": data_dir,
        "blobs": blobs,
        "database": database,
        "logs_dir": logs_dir,
        "fleet_executor": fleet_executor,
        "workers": workers,
        "no_token": no_token or None,
        "class_code": new_code() if open_class else None,
    }
    if logs_dir is not None and not logs_dir.is_dir():
        fail(f"--logs-dir: {logs_dir} is not a folder.")
    try:
        settings = Settings(**{name: value for name, value in options.items() if value is not None})
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        what = f"the setting {where} is" if where else "the settings are"
        fail(f"{what} refused: {first['msg'].removeprefix('Value error, ')}.")
    run(settings)


@app.command()
def upload(
    file: Annotated[
        Path,
        typer.Argument(
            metavar="FILE",
            help="A robot log, a cloud, an octree or a map.yaml; or the folder of a log or depth images.",
        ),
    ],
    url: Annotated[str, typer.Argument(metavar="URL", help="The address that the service prints.")],
    as_json: AsJson = False,
) -> None:
    """Send a log to a service, resume after a broken connection, and print the address of its map."""
    from server.client import Client  # noqa: PLC0415 - start-up
    from server.settings import Settings  # noqa: PLC0415 - start-up

    visitors = Settings().data_dir / "visitors.json"
    with refusing(file), progress_bar("Uploading") as progress, Client(url, visitors=visitors) as client:
        log = client.wait(client.upload(file, progress))
        link = client.address(client.open(log, playing=True))
    if as_json:
        print_json({**log.record, "link": link})
        return
    typer.echo(f"{log.name}: {_contents(log.record)}")
    print_notes(log.notes)
    typer.echo(f"  {link}")


def _contents(record: Mapping[str, Any]) -> str:
    """Say in words how much a log has of what it has (scans, points, costmaps or cells), and its format."""
    if record["map"] is not None:
        return f"a map of {record['map']['cols']} × {record['map']['rows']} cells"
    if record["clouds"]:
        unit = "leaves" if str(record["format"]).startswith("OctoMap") else "points"
        clouds = record["clouds"]
        found = f"{record['points']} {unit}" + (f" of {clouds} clouds" if clouds > 1 else "")
    elif record["costmaps"]:
        found = f"{record['costmaps']} costmap{'s' if record['costmaps'] != 1 else ''}"
    else:
        found = f"{record['scans']} scan{'s' if record['scans'] != 1 else ''} of {record['beams']} beams"
    return f"{found}, {record['format']}"


@app.command()
def notes(
    address: Annotated[
        str,
        typer.Argument(
            metavar="ADDRESS", help="The address of the log's page, as `gridbloom upload` prints it, or a link to it."
        ),
    ],
    out: Annotated[
        Path, typer.Option("--out", "-o", metavar="FILE", help="The file to write, .geojson, .json or .csv.")
    ] = Path("notes.geojson"),
) -> None:
    """Write the notes on a log of a service as GeoJSON or CSV, in metres of the frame of its poses."""
    from mapper.core.atomic_file import atomic_write  # noqa: PLC0415 - start-up
    from server.client import Client  # noqa: PLC0415 - start-up
    from server.settings import Settings  # noqa: PLC0415 - start-up

    wanted = NOTE_FILES.get(out.suffix.lower())
    if wanted is None:
        fail(f"{out}: notes are written as .geojson, .json or .csv.")
    try:
        with Client(address, visitors=Settings().data_dir / "visitors.json") as client, client.at(address) as found:
            data = client.notes(found, wanted)
    except MapperError as error:
        fail(error.message)
    try:
        with atomic_write(out) as file:
            file.write(data)
    except OSError as error:
        fail(f"{out}: {error.strerror}")
    typer.echo(f"{out} written")


def _folder(data_dir: Path | None) -> Path:
    """Return the data folder that is meant. Ends the command where it does not hold everything."""
    with fast_imports():
        from server.settings import Settings  # noqa: PLC0415 - start-up

        settings = Settings()
    if settings.database is not None or settings.blobs is not None:
        fail(ELSEWHERE)
    return data_dir or settings.data_dir


@app.command()
def backup(file: BackupFile, data_dir: DataDir = None) -> None:
    """Copy all logs and records of a service, which may be running, into one new file."""
    from server.library.backup import back_up  # noqa: PLC0415 - start-up

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
    from server.library.backup import restore as put_back  # noqa: PLC0415 - start-up

    folder = _folder(data_dir)
    with refusing(file):
        try:
            put_back(file, folder)
        except OSError as error:
            fail(f"{error.filename or folder}: {error.strerror or error}.")
    typer.echo(f"Restored {file} into {folder}.")
