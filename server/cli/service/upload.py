"""``upload`` sends a log to a service; ``notes`` writes the notes on one of its logs to a file."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any

import typer

from mapper.core.errors import MapperError
from server.cli.commands import app
from server.cli.common import AsJson, fail, output_file, print_json, print_notes, progress_bar, refusing
from server.client import Client, NoteFile
from server.settings import Settings

#: Kinds of files of notes by their ending.
NOTE_FILES: dict[str, NoteFile] = {".geojson": "geojson", ".json": "geojson", ".csv": "csv"}


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
    """Return a log's numbers of scans, points, costmaps or cells, and its format, in words."""
    if record["map"] is not None:
        return f"a map of {record['map']['cols']} × {record['map']['rows']} cells"
    if record["clouds"]:
        unit = "leaves" if str(record["format"]).startswith("OctoMap") else "points"
        clouds = record["clouds"]
        content = f"{record['points']} {unit}" + (f" of {clouds} clouds" if clouds > 1 else "")
    elif record["costmaps"]:
        content = f"{record['costmaps']} costmap{'s' if record['costmaps'] != 1 else ''}"
    else:
        content = f"{record['scans']} scan{'s' if record['scans'] != 1 else ''} of {record['beams']} beams"
    return f"{content}, {record['format']}"


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
    kind = NOTE_FILES.get(out.suffix.lower())
    if kind is None:
        fail(f"{out}: notes are written as .geojson, .json or .csv.")
    try:
        with Client(address, visitors=Settings().data_dir / "visitors.json") as client, client.at(address) as server:
            data = client.notes(server, kind)
    except MapperError as error:
        fail(error.message)
    with output_file(out) as file:
        file.write(data)
    typer.echo(f"{out} written")
