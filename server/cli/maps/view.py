"""``view`` draws a map file as text."""

from __future__ import annotations

import shutil
from pathlib import Path
from typing import Annotated

import typer

from mapper.grid.text import RAMP, density, three_state
from mapper.io.maps import load_map
from server.cli.commands import app
from server.cli.common import refusing


@app.command()
def view(
    map_yaml: Annotated[Path, typer.Argument(metavar="MAP.yaml", help="A map file.")],
    width: Annotated[int | None, typer.Option(help="Characters across. [the terminal's]")] = None,
) -> None:
    """Draw a map file as text: in three states, and in characters that grow denser with the occupancy."""
    across = shutil.get_terminal_size().columns if width is None else width
    with refusing(map_yaml):
        loaded = load_map(map_yaml)
        pictures = three_state(loaded.grid, across), density(loaded.grid, across)
    geometry = loaded.grid.geometry
    typer.echo(
        f"{map_yaml.name}: {geometry.size_text} cells of {geometry.resolution:g} m, "
        f"{loaded.description.mode}, origin {', '.join(f'{value:.10g}' for value in geometry.origin)}"
    )
    for note in loaded.notes:
        typer.echo(f"note: {note}")
    typer.echo("\n# occupied   . free   ? unknown\n" + pictures[0])
    typer.echo(f"\n{RAMP[0]} free … {RAMP[-1]} occupied, blank: never observed\n" + pictures[1])
