"""Shared parts of the commands: options, errors, progress."""

from __future__ import annotations

import inspect
import json
import re
import sys
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Annotated, Any, NoReturn

import typer

from mapper.core.atomic_file import atomic_write
from mapper.core.errors import LimitError, MapperError
from mapper.core.parameter import Parameter
from mapper.mapping.parameters import BY_NAME, RECORDED, MappingConfig
from mapper.sensors.planar.options import BY_NAME as CUT_BY_NAME
from mapper.sensors.planar.options import PlanarCut

BAD_INPUT = 2  #: exit status
MOUNT = ("mount_x", "mount_y", "mount_yaw")  #: one option for all three

#: Shorter or customary names of options. The table's own names are options too.
SHORT_NAMES = {
    "range_max": "--max-range",
    "log_odds_hit": "--hit",
    "log_odds_miss": "--miss",
}


LogPath = Annotated[Path, typer.Argument(metavar="LOG", help="A robot log, plain or compressed.")]
TopicName = Annotated[
    str | None, typer.Option("--topic", metavar="NAME", help="The sensor, where the log has several. [most scans]")
]
TopicNames = Annotated[
    list[str] | None,
    typer.Option(
        "--topic",
        metavar="NAME",
        help="The sensor, where the log has several; given again, another one in the same map. [most scans]",
    ),
]
TrajectoryName = Annotated[
    str | None, typer.Option("--trajectory", metavar="NAME", help="Poses to map with. [the log's first]")
]
TumTrajectory = Annotated[
    Path | None,
    typer.Option("--tum-trajectory", metavar="FILE", help="A TUM file as one more trajectory, 'tum', the log's first."),
]
TfTopic = Annotated[
    str | None,
    typer.Option(
        "--tf", metavar="TOPIC", help="The topic of transforms, where there are several. [tf of the sensor's namespace]"
    ),
]
Mount = Annotated[
    str | None,
    typer.Option("--mount", metavar="X,Y,YAW", help="Correction of the sensor's pose on the robot (m, m, rad)."),
]
FirstScans = Annotated[
    int | None, typer.Option("--scans", metavar="N", help="Map only the first N scans. [all that the log has]")
]
AsJson = Annotated[bool, typer.Option("--json", help="Print one JSON object and nothing else.")]


#: Codes of files that are no map, or no cloud → the sentence for those that are logs.
_A_MAP = "This is a log, and a map is needed here. `gridbloom map {path} --out out/map` makes one: out/map.yaml."
_A_CLOUD = "This is a log, and a file of a point cloud is needed here, as PCD, PLY or LAS."
#: Errors of a log that should perhaps be readable, but is not; the page uses the same.
TO_REPORT = re.compile(r"log\.(unknown_format|binary|garbage|no_scans|version|header|beam\w*|not_a_number|range\w*)")
NOT_A_LOG = {"map.yaml": _A_MAP, "map.key_missing": _A_MAP, "cloud.format": _A_CLOUD}


def fail(message: str) -> NoReturn:
    """Print an error sentence and end the command."""
    typer.echo(f"gridbloom: {message}", err=True)
    raise typer.Exit(BAD_INPUT)


def make_folder_of(path: Path) -> None:
    """Create the folder of an output file, or end the command with an error."""
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        _fail_to_write(path, error)


@contextmanager
def output_file(path: Path) -> Iterator[IO[bytes]]:
    """Open a file that is written completely or not at all; a file that cannot be written ends the command."""
    try:
        with atomic_write(path) as file:
            yield file
    except OSError as error:
        _fail_to_write(path, error)


def _fail_to_write(path: Path, error: OSError) -> NoReturn:
    fail(f"{path}: the file cannot be written: {error.strerror}.")


@contextmanager
def refusing(path: Path, notes: Iterable[str] = ()) -> Iterator[None]:
    """Report the mapper's errors about the file at ``path`` in one sentence, and a log in place of a map or a cloud.

    The error of a limit is followed by ``notes``, which may explain it.
    """
    try:
        yield
    except MapperError as error:
        more = "".join(f"\n  note: {note}" for note in notes) if isinstance(error, LimitError) else ""
        fail(f"{path}: {_instead_of(path, error.code) or error.message}{_how_to_report(error.code)}{more}")


def _how_to_report(code: str) -> str:
    """Return how to report an unreadable log, on a separate line; empty for other errors."""
    if not TO_REPORT.fullmatch(code):
        return ""
    what = "writes what a report of it needs, without readings or names."
    return f"\nIf it should be read: gridbloom info LOG --report {what}"


def _instead_of(path: Path, code: str) -> str | None:
    """Return what to do if a file that is no map, or no cloud, is a log; None if it is not."""
    sentence = next((text for begins, text in NOT_A_LOG.items() if code.startswith(begins)), None)
    if sentence is None:
        return None
    from mapper.io.logs import is_log  # noqa: PLC0415 - only on an error

    return sentence.format(path=path) if is_log(path) else None


def print_json(values: Mapping[str, object]) -> None:
    """Print one object on one line. Numbers without a JSON representation must have been replaced."""
    typer.echo(json.dumps(values, allow_nan=False, ensure_ascii=False))


def print_notes(notes: Iterable[str]) -> None:
    """Print a line for each note."""
    for note in notes:
        typer.echo(f"  note: {note}")


def _option(row: Parameter) -> inspect.Parameter:
    names = [SHORT_NAMES[row.name]] if row.name in SHORT_NAMES else []
    name = "--" + row.name.replace("_", "-")
    names.append(f"{name}/--no-{row.name.replace('_', '-')}" if row.kind == "flag" else name)
    unit = f" {row.unit}" if row.unit else ""
    first = RECORDED.get(row.name, row.initial)
    initial = first if row.kind != "flag" else ("on" if first else "off")
    bounds = f"; {row.low:g} to {row.high:g}{unit}" if row.kind == "number" else ""
    sentence = f"{row.sentence} [{initial}{unit if row.kind == 'number' else ''}{bounds}]"
    # A number is passed as typed, so that an invalid one is refused with the table's own message.
    kind: Any = bool | None if row.kind == "flag" else str | None
    metavar = {"number": "NUMBER", "choice": "|".join(row.choices), "flag": None}[row.kind]
    annotation = Annotated[kind, typer.Option(*names, help=sentence, metavar=metavar, show_default=False)]
    return inspect.Parameter(row.name, inspect.Parameter.KEYWORD_ONLY, default=None, annotation=annotation)


def with_parameter_options(
    *names: str, more: Sequence[Parameter] = ()
) -> Callable[[Callable[..., None]], Callable[..., None]]:
    """Give a command an option for each named row of the parameter table, in place of its ``**parameters``.

    It also gets one for each of the rows ``more`` of another table.
    """

    def widened(command: Callable[..., None]) -> Callable[..., None]:
        own = [p for p in inspect.signature(command, eval_str=True).parameters.values() if p.kind is not p.VAR_KEYWORD]
        options = [_option(row) for row in (*(BY_NAME[name] for name in names), *more)]
        signature = inspect.Signature([p.replace(kind=p.KEYWORD_ONLY) for p in own] + options)
        command.__signature__ = signature  # type: ignore[attr-defined]
        command.__annotations__ = {p.name: p.annotation for p in signature.parameters.values()}
        return command

    return widened


def value_of(row: Parameter, text: str) -> object:
    """Return the value of a typed parameter. Invalid text is returned unchanged, and refused by the table."""
    if row.kind == "choice":
        return text.replace("-", "_")
    if row.kind == "flag":
        return {"on": True, "true": True, "off": False, "false": False}.get(text.lower(), text)
    try:
        return float(text)
    except ValueError:
        return text


def given_values(rows: Mapping[str, Parameter], values: Mapping[str, object]) -> dict[str, Any]:
    """Return the given values of a table's options, those that are not None."""
    return {
        name: value_of(rows[name], value) if isinstance(value, str) else value
        for name, value in values.items()
        if value is not None
    }


def set_values(rows: Mapping[str, Parameter], texts: Iterable[str], option: str = "--set") -> dict[str, object]:
    """Return the values of a table given by ``option`` as NAME=VALUE, or end the command with an error.

    An unknown name is returned with its text, and refused by the table.
    """
    values: dict[str, object] = {}
    for text in texts:
        name, equals, value = text.partition("=")
        if not equals:
            fail(f"{option} needs NAME=VALUE, not {text!r:.80}.")
        name = name.strip().replace("-", "_")
        values[name] = value_of(rows[name], value.strip()) if name in rows else value
    return values


def given_parameters(values: Mapping[str, object], mount: str | None = None) -> dict[str, object]:
    """Return the given parameters, or end the command with an error."""
    parameters: dict[str, object] = given_values(BY_NAME, values)
    if mount is not None:
        parameters |= zip(
            MOUNT, numbers("--mount", "three numbers, X,Y,YAW in metres and radians", 3, mount), strict=True
        )
    configured(parameters)
    return parameters


def configured(values: Mapping[str, object]) -> MappingConfig:
    """Return the parameters with the given ones replaced, or end the command with an error."""
    try:
        return MappingConfig().with_values(values)
    except MapperError as error:
        fail(error.message)


def given_cut(values: dict[str, object]) -> PlanarCut:
    """Remove the options of planar cuts from ``values``; return the cut, or end the command with an error."""
    cut = given_values(CUT_BY_NAME, {name: values.pop(name) for name in CUT_BY_NAME if name in values})
    try:
        return PlanarCut(**cut)
    except MapperError as error:
        fail(error.message)


def place(text: str) -> list[float]:
    """Return the given point X,Y, or end the command with an error."""
    return numbers("--at", "two numbers, X,Y in metres", 2, text)


def numbers(option: str, expected: str, count: int, text: str) -> list[float]:
    """Return the ``count`` numbers of an option, or end the command with an error that states what is ``expected``."""
    try:
        values = [float(part) for part in text.split(",")]
    except ValueError:
        values = []
    if len(values) != count:
        fail(f"{option} needs {expected}, not {text!r:.40}.")
    return values


@contextmanager
def progress_bar(what: str) -> Iterator[Callable[[float], None] | None]:
    """Yield a function that shows the progress, 0 to 1; None without a terminal."""
    if not sys.stderr.isatty():
        yield None
        return
    from rich.console import Console  # noqa: PLC0415 - start-up
    from rich.progress import Progress  # noqa: PLC0415 - start-up

    with Progress(console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task(what, total=1.0)
        yield lambda share: bar.update(task, completed=share)
