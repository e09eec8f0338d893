"""``fleet``: read, examine and map many logs."""

from __future__ import annotations

import time
from itertools import starmap
from pathlib import Path
from typing import Annotated, Any, Literal

import typer

from server.cli.commands import app
from server.cli.common import (
    AsJson,
    Mount,
    TfTopic,
    TrajectoryName,
    configured,
    given_parameters,
    print_json,
    progress_bar,
    refusing,
    with_parameter_options,
)
from server.fleet import Fleet, Result, workers_at
from server.fleet.page import PAGE, line_of, ordered, write_page
from server.library.processing.fleet.fleet_job import LIMITS, LogOptions

PAGE_EVERY_S = 1.0


@app.command()
@with_parameter_options("mount_upside_down", "time_offset")
def fleet(
    logs: Annotated[list[Path], typer.Argument(metavar="LOGS...", help="Robot logs, plain or compressed.")],
    out: Annotated[Path, typer.Option(help="Folder of the results; a run that was ended goes on from it.")],
    executor: Annotated[
        str | None,
        typer.Option(
            help="Scheduler of a Dask cluster, tcp://HOST:PORT or tls://HOST:PORT. [this machine's processes]"
        ),
    ] = None,
    workers: Annotated[int | None, typer.Option(min=1, help="Logs done at once. [all cores]")] = None,
    again: Annotated[bool, typer.Option("--again", help="Do the logs again that failed in an earlier run.")] = False,
    order: Annotated[
        Literal["name", "drift", "findings", "sharpness", "scans", "size"],
        typer.Option("--sort", help="Order of the lines: by name, or the most first, of sharpness the least."),
    ] = "name",
    topic: Annotated[
        str | None, typer.Option(metavar="NAME", help="The sensor of each log. [the one with most scans]")
    ] = None,
    trajectory: TrajectoryName = None,
    tf: TfTopic = None,
    mount: Mount = None,
    as_json: AsJson = False,
    **parameters: Any,  # noqa: ANN401 - one option for each named row of the table
) -> None:
    """Read, examine and map many logs; OUT/index.html shows the maps as they are made."""
    began = time.monotonic()
    limits = LIMITS
    mapping = given_parameters(parameters, mount)
    configured(mapping)
    whole = Fleet(logs, out, limits, LogOptions(topic, tf, trajectory, mapping))
    with refusing(out), whole.held():
        before = len(whole.results)
        written = 0.0
        with (
            progress_bar("Mapping") as bar,
            workers_at(executor, workers, limits.memory_bytes) as crew,
        ):

            def note(_: Result) -> None:
                nonlocal written
                if bar is not None:
                    bar(len(whole.results) / len(whole.logs))
                if time.monotonic() - written > PAGE_EVERY_S:
                    written = time.monotonic()
                    write_page(whole, running=True)

            write_page(whole, running=True)
            try:
                whole.run(crew, note, again=again)
            finally:
                write_page(whole, running=False)
    failed = [result for result in whole.results.values() if result.failed]
    if as_json:
        results = {key: result.public() for key, result in whole.results.items()}
        print_json({"logs": len(whole.logs), "failed": len(failed), "results": results})
    else:
        ended = f"{len(whole.results)} of {len(whole.logs)} logs, {before} of them before, {len(failed)} failed"
        typer.echo(f"{ended}, in {time.monotonic() - began:.1f} s")
        for line in starmap(line_of, ordered([*whole.results.values()], order)):
            typer.echo(f"  {line}")
        for failure in failed:
            typer.echo(f"  {failure.log}: {failure.message}")
        typer.echo(f"  {out / PAGE}")
    if failed:
        raise typer.Exit(1)
