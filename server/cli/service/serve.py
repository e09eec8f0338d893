"""``serve`` runs the service."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated, Any

import typer

from server.cli.commands import app
from server.cli.common import fail
from server.imports import fast_imports

with fast_imports():
    from pydantic import ValidationError

    from server.classes.classes import new_code
    from server.serving import run
    from server.settings import Settings, unknown_setting


@app.command()
def serve(
    host: Annotated[str | None, typer.Option(help="Address to listen on. [127.0.0.1]")] = None,
    port: Annotated[int | None, typer.Option(help="Port to listen on; 0 chooses a free one. [8000]")] = None,
    data_dir: Annotated[
        Path | None,
        typer.Option(
            readable=False,  # it may not exist yet; errors are reported below
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
    if unknown := unknown_setting(os.environ):
        fail(unknown)
    if open_class:
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
