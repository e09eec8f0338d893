"""``check``: whether a log is within limits, as an exit status."""

from __future__ import annotations

import math
from typing import Annotated, Any

import typer

from mapper.core.errors import MapperError
from mapper.diagnosis import Limits, judge, named_findings
from server.cli.commands import app
from server.cli.common import (
    AsJson,
    LogPath,
    Mount,
    TfTopic,
    TopicNames,
    TumTrajectory,
    configured,
    fail,
    given_parameters,
    print_json,
    progress_bar,
    refusing,
    with_parameter_options,
)
from server.cli.reading import read_joint

FAILED = 1  #: exit status


@app.command()
@with_parameter_options("mount_upside_down", "time_offset")
def check(
    log: LogPath,
    max_drift: Annotated[
        float | None,
        typer.Option(
            metavar="METRES",
            help="The distance between walls and their copies that may be exceeded by a tenth of the readings at most.",
        ),
    ] = None,
    min_sharpness: Annotated[
        float | None,
        typer.Option(metavar="0..1", help="The least contrast of walls, in the map with default parameters."),
    ] = None,
    no_findings: Annotated[
        str | None,
        typer.Option(
            metavar="NAMES", help="Findings of the doctor that make the check fail: clock,mount.offset or all."
        ),
    ] = None,
    possible: Annotated[
        bool, typer.Option("--possible", help="Let findings count, too, that the doctor states as possible.")
    ] = False,
    topic: TopicNames = None,
    trajectory: Annotated[str | None, typer.Option(metavar="NAME", help="Poses to judge. [the log's first]")] = None,
    tum_trajectory: TumTrajectory = None,
    tf: TfTopic = None,
    mount: Mount = None,
    as_json: AsJson = False,
    **parameters: Any,  # noqa: ANN401 - one option for each named row of the table
) -> None:
    """Judge a log by limits: exit status 0 where it keeps them, 1 where not, with the reasons."""
    if max_drift is None and min_sharpness is None and no_findings is None:
        fail("Nothing to check: give --max-drift, --min-sharpness or --no-findings.")
    _check_number("--max-drift", max_drift, math.inf, "a number of metres from 0")
    _check_number("--min-sharpness", min_sharpness, 1.0, "a number from 0 to 1")
    try:
        names = named_findings([] if no_findings is None else [name.strip() for name in no_findings.split(",")])
    except MapperError as error:
        fail(f"--no-findings: {error.message}")
    config = configured(given_parameters(parameters, mount))
    scans = read_joint(log, topic or (), tum_trajectory, tf)
    with refusing(log), progress_bar("Checking") as bar:
        verdict = judge(scans, Limits(max_drift, min_sharpness, names, possible), trajectory, config, bar)
    if as_json:
        print_json({"log": scans.name, "trajectory": trajectory or scans.default_trajectory, **verdict.public()})
    else:
        measured = [
            f"drift {verdict.drift:.2f} m" if verdict.drift is not None else "",
            f"sharpness {verdict.sharpness:.3f}" if verdict.sharpness is not None else "",
        ]
        results = ["passed" if verdict.passed else "failed", *(drift_ for drift_ in measured if drift_)]
        typer.echo(f"{scans.name}: {', '.join(results)}")
        for reason in verdict.reasons:
            of = f" of {reason.sensor}" if reason.sensor else ""
            typer.echo(f"  {reason.check}{of}: {reason.sentence}")
    if not verdict.passed:
        raise typer.Exit(FAILED)


def _check_number(option: str, value: float | None, greatest: float, expected: str) -> None:
    """End the command if ``value`` is given and not a finite number from 0 to ``greatest``."""
    if value is not None and not (math.isfinite(value) and 0.0 <= value <= greatest):
        fail(f"{option} needs {expected}, not {value:g}.")
