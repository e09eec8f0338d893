"""The ``gridbloom`` command itself, to which the other modules add its parts."""

from __future__ import annotations

import typer

app = typer.Typer(
    help="Watch an occupancy grid map fill in: a live world, and robot logs.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)
bench_app = typer.Typer(no_args_is_help=True)
app.add_typer(bench_app, name="bench")
