"""``edit``: apply a list of edits to a map file."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from mapper.editing import EditedMap
from mapper.editing.files import apply_edits, read_edits, save_edited
from mapper.io.maps import load_map
from server.cli.commands import app
from server.cli.common import AsJson, print_json, print_notes, refusing


@app.command()
def edit(
    map_yaml: Annotated[Path, typer.Argument(metavar="MAP.yaml", help="A map file.")],
    edits: Annotated[Path, typer.Option(metavar="EDITS.json", help="The edits, as the page of a map saves them.")],
    out: Annotated[Path, typer.Option(metavar="PREFIX", help="Write PREFIX.pgm, PREFIX.yaml and PREFIX.edits.json.")],
    as_json: AsJson = False,
) -> None:
    """Edit a map: paint, remove specks, zones, speed limits, turn, crop, move the origin, as a file of edits says."""
    with refusing(map_yaml):
        loaded = load_map(map_yaml)
        edited = EditedMap(loaded.grid.geometry, loaded.values)
    with refusing(edits):
        source, operations = read_edits(edits)
        apply_edits(edited, source, operations)
    with refusing(out):
        paths = save_edited(edited, out, map_yaml.name, loaded.description.frame)
    geometry = edited.geometry
    facts = {
        "map": str(map_yaml),
        "edits": len(operations),
        "width": geometry.cols,
        "height": geometry.rows,
        "origin": [round(value, 6) for value in geometry.origin],
        "changed": int((edited.values != loaded.values).sum()) if edited.values.shape == loaded.values.shape else None,
        "keepout_cells": int((edited.keepout > 0).sum()),
        "speed_cells": int((edited.speed > 0).sum()),
        "files": [str(path) for path in paths],
        "notes": list(loaded.notes),
    }
    if as_json:
        print_json(facts)
        return
    zones = f"{facts['keepout_cells']} keepout cells, {facts['speed_cells']} cells with a speed limit"
    typer.echo(f"{len(operations)} edits, {geometry.size_text} cells, {zones}")
    for path in paths:
        typer.echo(f"  wrote {path}")
    print_notes(loaded.notes)
