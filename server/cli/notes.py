"""``notes`` writes the notes on a log of a service as GeoJSON or CSV."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from mapper.core.errors import MapperError
from server.cli.common import app, fail

if TYPE_CHECKING:
    from server.client import NoteFile

#: By the ending of the file that is written.
FILES: dict[str, NoteFile] = {".geojson": "geojson", ".json": "geojson", ".csv": "csv"}


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

    wanted = FILES.get(out.suffix.lower())
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
