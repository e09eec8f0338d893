"""``evaluate``: the errors of poses, against a reference or against known relations between places."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Annotated, Literal

import typer

from mapper.evaluation import (
    PUBLISHED,
    ComparisonOptions,
    ErrorSeries,
    PublishedResult,
    RelationErrors,
    benchmark_named,
    compare_trajectories,
    evaluate_relations,
)
from mapper.io.logs import is_log, odometry_records
from mapper.io.trajectories import read_relations, read_tum
from mapper.sensors.scan import ScanLog
from mapper.sensors.timed_poses import TimedPoses
from server.cli.commands import app
from server.cli.common import AsJson, TfTopic, TopicName, fail, print_json, print_notes, refusing
from server.cli.reading import read_log

Read = Callable[[Path], ScanLog]  #: reads a log according to the options

FIGURES = ("rmse", "mean", "median", "std", "min", "max", "sse")
NAMES = {"rigid": "rotation and translation", "scaled": "rotation, translation and scale", "origin": "first pose"}


@app.command()
def evaluate(
    reference: Annotated[
        str, typer.Argument(metavar="REFERENCE", help="A TUM file, or LOG:TRAJECTORY, or LOG for its first trajectory.")
    ],
    estimate: Annotated[
        str | None,
        typer.Argument(
            metavar="ESTIMATE", help="The trajectory to evaluate, as REFERENCE. [with --relations: that of the log]"
        ),
    ] = None,
    relations: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE",
            help="Known relations (Kümmerle et al. 2009); REFERENCE is their log then. Published results are printed "
            "too, of a log of that benchmark by the file's name, as intel.relations.",
        ),
    ] = None,
    max_difference: Annotated[float, typer.Option(metavar="S", help="Greatest difference of stamps of a pair.")] = 0.01,
    offset: Annotated[float, typer.Option(metavar="S", help="Seconds to add to the stamps of ESTIMATE.")] = 0.0,
    align: Annotated[
        Literal["rigid", "scaled", "origin", "none"],
        typer.Option(
            help="Bring ESTIMATE onto REFERENCE by least squares, with a scale too, by the first pose, or not."
        ),
    ] = "rigid",
    delta: Annotated[
        float, typer.Option(metavar="NUMBER", help="Distance, time or number of poses of the relative error.")
    ] = 1.0,
    delta_unit: Annotated[Literal["m", "s", "frames"], typer.Option(help="Unit of delta.")] = "m",
    all_pairs: Annotated[
        bool, typer.Option("--all-pairs", help="Begin a pair at each pose. [one after another]")
    ] = False,
    pairs_from_reference: Annotated[
        bool, typer.Option("--pairs-from-reference", help="Measure delta along REFERENCE. [ESTIMATE]")
    ] = False,
    topic: TopicName = None,
    tf: TfTopic = None,
    as_json: AsJson = False,
) -> None:
    """Print the errors of a trajectory against a reference, as evo does, or over known relations."""

    def read(path: Path) -> ScanLog:
        return read_log(path, topic, tf=tf)

    if relations is not None:
        _evaluate_relations(reference, estimate, relations, read, as_json=as_json)
        return
    if estimate is None:
        fail("evaluate needs a REFERENCE and an ESTIMATE, or a LOG and --relations FILE.")
    sides = _poses(reference, read), _poses(estimate, read)
    options = ComparisonOptions(
        max_difference_s=max_difference,
        offset_s=offset,
        align=align,
        delta=delta,
        delta_unit=delta_unit,
        all_pairs=all_pairs,
        pairs_from_reference=pairs_from_reference,
    )
    with refusing(Path(estimate)):
        errors = compare_trajectories(*sides, options)
    absolute = {"translation": errors.absolute_translation, "rotation": errors.absolute_rotation}
    relative = {"translation": errors.relative_translation, "rotation": errors.relative_rotation}
    notes = [f"{text}: {note}" for text, side in zip((reference, estimate), sides, strict=True) for note in side.notes]
    if as_json:
        print_json(
            {
                "reference": {"name": reference, "poses": len(sides[0])},
                "estimate": {"name": estimate, "poses": len(sides[1])},
                "pairs": len(errors.estimate),
                "max_difference_s": max_difference,
                "offset_s": offset,
                "alignment": {"how": align, **asdict(errors.alignment)},
                "absolute": _figures(absolute),
                "relative": {
                    "delta": delta,
                    "unit": delta_unit,
                    "all_pairs": all_pairs,
                    "pairs": len(errors.relative_translation.errors),
                    **_figures(relative),
                },
                "notes": notes,
            }
        )
        return
    typer.echo(f"{estimate} against {reference}")
    typer.echo(
        f"  {len(errors.estimate)} pairs of poses, of {len(sides[1])} and {len(sides[0])}, within {max_difference:g} s"
    )
    if align != "none":
        by = errors.alignment
        scale = f", scale {by.scale:.6g}" if align == "scaled" else ""
        typer.echo(f"  aligned by {NAMES[align]}: {by.x:.3f} m, {by.y:.3f} m, {math.degrees(by.theta):.3f}°{scale}")
    which = "all" if all_pairs else "consecutive"
    _table("absolute error", absolute)
    _table(f"relative error over {delta:g} {delta_unit}, {len(relative['rotation'].errors)} {which} pairs", relative)
    print_notes(notes)


def _evaluate_relations(log: str, estimate: str | None, relations: Path, read: Read, *, as_json: bool) -> None:
    """Print the errors of a log's poses, or of others of its scans, over known relations."""
    path, name = _path_and_name(log)
    if not is_log(path):
        fail(f"{path}: The relations need the log that they belong to, which this is not.")
    scans = read(path)
    with refusing(relations):
        known = read_relations(relations)
    poses = _of_log(path, scans, name) if estimate is None else _poses(estimate, read)
    if len(poses) != scans.n_scans:
        fail(f"{estimate}: There are {len(poses)} poses, and {scans.n_scans} scans in the log: one for each is needed.")
    with refusing(path):
        records = odometry_records(path, topic=scans.topic)
        # A pose belongs to the scan with its number, because stamps repeat, and programs change them.
        at_scans = type(poses)(scans.stamps_ns, poses.poses, poses.notes)
        errors = evaluate_relations(known, at_scans, records)
    judged = estimate or f"{path}:{name or scans.default_trajectory}"
    every = {"translation": errors.translation, "rotation": errors.rotation}
    clear = dict(zip(every, errors.only_unambiguous(), strict=True)) if errors.policy == "records" else None
    if clear is not None and not len(clear["translation"].errors):
        clear = None
    benchmark = benchmark_named(relations.name)
    published = () if benchmark is None else PUBLISHED[benchmark]
    if as_json:
        print_json(
            {
                "log": str(path),
                "estimate": judged,
                "relations": len(known),
                "policy": errors.policy,
                "left_out": errors.left_out,
                "all": {"count": len(errors.translation.errors), **_figures(every)},
                "unambiguous": None
                if clear is None
                else {"count": len(clear["translation"].errors), **_figures(clear)},
                "benchmark": benchmark,
                "published": [asdict(entry) for entry in published],
                "notes": list(poses.notes),
            }
        )
        return
    typer.echo(f"{judged} over {len(known)} relations")
    typer.echo(
        "  stamps mapped to the log's odometry messages, in the order of its records"
        if errors.policy == "records"
        else "  poses interpolated in time between the scans"
    )
    if errors.left_out:
        left_out = "1 relation is" if errors.left_out == 1 else f"{errors.left_out} relations are"
        typer.echo(f"  {left_out} left out: the log has no record at their times")
    _table(f"all, {len(errors.translation.errors)} relations", every)
    if clear is not None:
        _table(f"unambiguous, {len(clear['translation'].errors)} relations of one message for each stamp", clear)
    if published:
        _beside(published, errors, clear)
    print_notes(poses.notes)


def _beside(published: Sequence[PublishedResult], errors: RelationErrors, clear: dict[str, ErrorSeries] | None) -> None:
    """Print the mean errors of the poses next to published ones."""
    rows = [("these poses", errors.translation, errors.rotation)]
    if clear is not None:
        rows.append(("these poses, unambiguous", clear["translation"], clear["rotation"]))
    typer.echo("  mean errors beside published ones")
    typer.echo(f"    {'':<26} {'m':>8} {'°':>8} {'stamps by':>10} {'relations':>10}  source")
    for name, translation, rotation in rows:
        t, r = translation.statistics.mean, math.degrees(rotation.statistics.mean)
        typer.echo(f"    {name:<26} {t:>8.4f} {r:>8.3f} {errors.policy:>10} {len(translation.errors):>10}")
    for entry in published:
        turn = "–" if entry.rotation is None else f"{entry.rotation:.3f}"
        count = "–" if entry.count is None else str(entry.count)
        typer.echo(
            f"    {entry.program:<26} {entry.translation:>8.4f} {turn:>8} {entry.policy:>10} {count:>10}  "
            f"{entry.source}"
        )


def _path_and_name(text: str) -> tuple[Path, str | None]:
    """Return a file and, for LOG:TRAJECTORY, the name of the trajectory."""
    if not Path(text).exists():
        for at, letter in enumerate(text):
            if letter == ":" and Path(text[:at]).exists():
                return Path(text[:at]), text[at + 1 :]
    return Path(text), None


def _poses(text: str, read: Read) -> TimedPoses:
    """Return the poses of a TUM file, or of a log's trajectory, or end the command with an error."""
    path, name = _path_and_name(text)
    if is_log(path):
        return _of_log(path, read(path), name)
    if name is not None:
        fail(f"{path}: The file is not a log, so it has no trajectory {name!r:.80}.")
    with refusing(path):
        return read_tum(path)


def _of_log(path: Path, log: ScanLog, name: str | None) -> TimedPoses:
    with refusing(path):
        return TimedPoses(log.stamps_ns, log.trajectory(name).poses)


def _figures(errors: dict[str, ErrorSeries]) -> dict[str, dict[str, float]]:
    units = {"translation": "m", "rotation": "rad"}
    return {f"{kind}_{units[kind]}": asdict(series.statistics) for kind, series in errors.items()}


def _table(title: str, errors: dict[str, ErrorSeries]) -> None:
    """Print the figures of errors; angles in degrees."""
    typer.echo(f"  {title}")
    typer.echo(" " * 19 + "".join(f" {name:>11}" for name in FIGURES))
    for kind, series in errors.items():
        figures: dict[str, float] = asdict(series.statistics)
        if kind == "rotation":
            figures = {
                name: math.degrees(math.degrees(value)) if name == "sse" else math.degrees(value)
                for name, value in figures.items()
            }
        unit = "°" if kind == "rotation" else "m"
        row = "".join(f" {figures[name]:>11.5g}" for name in FIGURES)
        typer.echo(f"    {f'{kind} ({unit})':<15}{row}")
