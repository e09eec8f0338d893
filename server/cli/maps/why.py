"""``why``: the updates of a cell."""

from __future__ import annotations

from typing import Annotated, Any

import typer

from mapper.mapping.parameters import PARAMETERS, recorded_defaults
from mapper.replay import Replay
from server.cli.commands import app
from server.cli.common import (
    MOUNT,
    AsJson,
    FirstScans,
    LogPath,
    Mount,
    TfTopic,
    TopicName,
    TrajectoryName,
    TumTrajectory,
    configured,
    given_parameters,
    place,
    print_json,
    print_notes,
    refusing,
    with_parameter_options,
)
from server.cli.maps.prior import Prior, PriorFrame, given_prior
from server.cli.reading import read_log


@app.command()
@with_parameter_options(*(row.name for row in PARAMETERS if row.name not in (*MOUNT, "log_odds_prior")))
def why(
    log: LogPath,
    at: Annotated[str, typer.Option(metavar="X,Y", help="A point in the cell, in map coordinates (m, m).")],
    topic: TopicName = None,
    trajectory: TrajectoryName = None,
    tum_trajectory: TumTrajectory = None,
    tf: TfTopic = None,
    mount: Mount = None,
    prior: Prior = None,
    prior_frame: PriorFrame = None,
    first_scans: FirstScans = None,
    as_json: AsJson = False,
    **parameters: Any,  # noqa: ANN401 - one option for each row of the table
) -> None:
    """Print the updates of a cell: every beam that changed it, and what each beam added."""
    point = place(at)
    values, prior_map = given_prior(prior, prior_frame, given_parameters(parameters, mount))
    scans = read_log(log, topic, tum_trajectory, tf)
    notes = prior_map.notes_for(scans, trajectory) if prior_map else ()
    config = configured(recorded_defaults(scans.beam_width, values))
    with refusing(log):
        replay = Replay(scans, config, trajectory, prior=prior_map.grid if prior_map else None)
        replay.advance_to(scans.n_scans if first_scans is None else first_scans)
        row, col = (int(n) for n in replay.grid.geometry.world_to_cell(point))
        why = replay.provenance(row, col)
    contributions = [
        {
            "scan": scan,
            "beam": beam,
            "range": round(reading, 3) if reading <= scans.range_max else None,
            "hit": hit,
            "outweighed": outweighed,
            "increment": round(increment, 6),
            "log_odds": round(log_odds, 6),
        }
        for scan, beam, reading, hit, outweighed, increment, log_odds in zip(
            why.scans.tolist(),
            why.beams.tolist(),
            why.ranges.tolist(),
            why.hits.tolist(),
            why.outweighed.tolist(),
            why.increments.tolist(),
            why.log_odds.tolist(),
            strict=True,
        )
    ]
    facts: dict[str, object] = {
        "log": scans.name,
        "scans": replay.index,
        "row": row,
        "col": col,
        "prior": round(why.prior, 6),
        "log_odds": round(why.after, 6),
        "p_occ": round(float(replay.grid.p_occ[row, col]), 6),
        "hits": int(why.hits.sum()),
        "contributions": contributions,
        "notes": list(notes),
    }
    if as_json:
        print_json(facts)
        return
    typer.echo(f"{facts['log']}: cell ({row}, {col}) after {replay.index} scans")
    typer.echo(
        f"  log-odds {why.after:.3f}, p {facts['p_occ']:.3f}, from {why.prior:g}: {len(contributions)} beams, "
        f"{facts['hits']} of them hits"
    )
    if contributions:
        typer.echo("    scan  beam  range (m)  increment  log-odds")
    for touch in contributions:
        reading = "no return" if touch["range"] is None else f"{touch['range']:.3f}"
        typer.echo(
            f"  {touch['scan']:6} {touch['beam']:5} {reading:>10} {touch['increment']:+10.3f} {touch['log_odds']:9.3f}"
            + ("  passed; the scan hits the cell" if touch["outweighed"] else "")
        )
    print_notes(notes)
