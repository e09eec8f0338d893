"""``--prior``: a number, or a map file that mapping continues."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import typer

from mapper.grid import OccupancyGrid
from mapper.io.maps import load_map
from mapper.mapping.integrate import check_resolution
from mapper.mapping.parameters import BY_NAME, MappingConfig
from mapper.sensors.scan import ScanLog
from server.cli.common import configured, fail, refusing, value_of

Prior = Annotated[
    str | None,
    typer.Option(
        "--prior",
        "--log-odds-prior",
        metavar="NUMBER|MAP.yaml",
        help=f"{BY_NAME['log_odds_prior'].sentence} Or a map file that mapping continues. [0; -2 to 2]",
    ),
]
PriorFrame = Annotated[
    str | None,
    typer.Option(
        "--prior-frame",
        metavar="FRAME",
        help="Frame of the prior map, which the poses must be in too. [what its yaml states, or map]",
    ),
]
DEFAULT_FRAME = "map"  #: of a map file that does not state its frame (REP 105)


@dataclass(frozen=True, slots=True)
class PriorMap:
    """A prior map, and its frame; ``is_frame_given`` says that the frame was given on the command line."""

    path: Path
    grid: OccupancyGrid
    notes: tuple[str, ...]
    frame: str
    is_frame_given: bool

    def notes_for(self, log: ScanLog, trajectory: str | None) -> tuple[str, ...]:
        """Return the notes on this map as the prior of ``log``; end the command if their frames differ."""
        with refusing(self.path):
            frame = log.trajectory(trajectory).frame_id
        name = trajectory or log.default_trajectory
        if frame is None:
            note = f"The frame of trajectory {name!r} is not known; it is taken to be the prior map's, {self.frame!r}."
            return self.notes if self.is_frame_given else (*self.notes, note)
        if frame != self.frame:
            fail(
                f"{self.path}: The prior map is in frame {self.frame!r:.80}, but the poses of trajectory {name!r:.80} "
                f"are in frame {frame!r:.80}. {self._remedy(log, frame)} "
                f"To find the robot in the map, run 'gridbloom localize LOG --map {self.path} --out poses.tum'."
            )
        if frame.startswith("odom"):
            note = f"The frame {frame!r} starts again with each run; the prior map must come from the run of this log."
            return (*self.notes, note)
        return self.notes

    def _remedy(self, log: ScanLog, frame: str) -> str:
        others = [name for name, trajectory in log.trajectories.items() if trajectory.frame_id == self.frame]
        chosen = f"Choose poses in its frame with --trajectory {others[0]}, or" if others else "If that is wrong,"
        return f"{chosen} state the frame of the prior map with --prior-frame {frame}."


def given_prior(
    text: str | None, frame: str | None, values: dict[str, object]
) -> tuple[dict[str, object], PriorMap | None]:
    """Return the parameters with a prior that is a number or a map file, and the map.

    Unless another resolution is given, it is that of the map.
    """
    number = None if text is None else value_of(BY_NAME["log_odds_prior"], text)
    if text is None or isinstance(number, float):
        if frame is not None:
            fail("--prior-frame needs a map file, given with --prior.")
        if number is not None:
            values = values | {"log_odds_prior": number}
            configured(values)
        return values, None

    path = Path(text)
    with refusing(path):
        loaded = load_map(path)
        values = {"resolution": loaded.grid.geometry.resolution} | values
        check_resolution(loaded.grid, MappingConfig().with_values(values))
    stated = frame or loaded.description.frame or DEFAULT_FRAME
    return values, PriorMap(path, loaded.grid, loaded.notes, stated, frame is not None)
