"""The ``gridbloom`` application object. A command's module is imported when the command is called.

The command therefore starts quickly, and ``--help`` needs no module.
"""

from __future__ import annotations

import ast
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from types import MappingProxyType
from typing import Annotated, Any

import typer
from typer.core import TyperCommand, TyperGroup
from typer.main import get_group

from server.version import package_version

#: The folder and module of each command, and its function there, in the order of ``--help``.
COMMANDS: Mapping[str, tuple[str, str]] = MappingProxyType(
    {
        "serve": ("service.serve", "serve"),
        "upload": ("service.upload", "upload"),
        "notes": ("service.upload", "notes"),
        "backup": ("service.backup", "backup"),
        "restore": ("service.backup", "restore"),
        "info": ("logs.info", "info"),
        "doctor": ("logs.info", "doctor"),
        "check": ("logs.check", "check"),
        "report": ("logs.report", "report"),
        "map": ("maps.map_log", "map_log"),
        "view": ("maps.view", "view"),
        "why": ("maps.why", "why"),
        "merge": ("maps.merge", "merge"),
        "compare": ("maps.compare", "compare"),
        "evaluate": ("poses.evaluate", "evaluate"),
        "match": ("poses.match", "match"),
        "slam": ("poses.slam", "slam"),
        "localize": ("poses.localize", "localize"),
        "edit": ("maps.edit", "edit"),
        "costmap": ("maps.costmap", "costmap"),
        "path": ("maps.path", "path"),
        "map3d": ("clouds.map3d", "map3d"),
        "terrain": ("clouds.terrain", "terrain"),
        "fleet": ("logs.fleet", "fleet"),
        "bench": ("maps.bench", "bench"),
    }
)


def load(name: str) -> TyperCommand | TyperGroup:
    """Import the module of one of :data:`COMMANDS`, which adds it to :data:`app`, and return the command."""
    import_module(f"server.cli.{COMMANDS[name][0]}")
    command = get_group(app).commands[name]
    if not isinstance(command, TyperCommand | TyperGroup):
        raise TypeError(name)
    return command


class _Command(TyperCommand):
    """A command whose module is imported when it is called. Its entry in ``--help`` is read from its source."""

    def __init__(self, name: str) -> None:
        super().__init__(name)
        self._name = name

    def get_short_help_str(self, limit: int = 45) -> str:
        module, function = COMMANDS[self._name]
        source = Path(__file__).parent.joinpath(*module.split(".")).with_suffix(".py")
        tree = ast.parse(source.read_text(encoding="utf-8"))
        defined = next(node for node in tree.body if isinstance(node, ast.FunctionDef) and node.name == function)
        self.help = ast.get_docstring(defined)
        return super().get_short_help_str(limit)

    def make_context(self, *args: Any, **kwargs: Any) -> Any:  # noqa: ANN401 - those of typer
        return load(self._name).make_context(*args, **kwargs)


class _Group(TyperGroup):
    """All of :data:`COMMANDS`, including those whose modules are not imported yet."""

    def __init__(self, **attributes: Any) -> None:  # noqa: ANN401 - those of typer
        super().__init__(**attributes)
        self.commands = {name: self.commands.get(name) or _Command(name) for name in COMMANDS}


app = typer.Typer(
    cls=_Group,
    help="Occupancy grid maps of simulated worlds and robot logs.",
    no_args_is_help=True,
    add_completion=False,
    rich_markup_mode=None,
    pretty_exceptions_enable=False,
)


def _print_version(is_set: bool) -> None:
    if is_set:
        typer.echo(f"gridbloom {package_version()}")
        raise typer.Exit


@app.callback()
def options(
    show_version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version and exit.")
    ] = False,
) -> None:
    """Options of the command itself."""
