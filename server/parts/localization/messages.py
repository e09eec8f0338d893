"""The stream's command and message of a localization."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING, Annotated

from msgspec import Meta, Struct

from server.stream.message_parts import Pose, UncheckedValues, Values

if TYPE_CHECKING:
    from mapper.core.array_types import Float64Array

COLUMNS = ("x", "y", "yaw", "value")  #: of the particle layer


class LocalizeCommand(Struct, tag_field="type", tag="localize"):
    """Simulations: begin to localize the robot in a map, from an unknown pose, change the parameters, or end it."""

    value: Annotated[bool, Meta(description="whether it is localized")] = False
    values: Annotated[UncheckedValues, Meta(description="localization parameters that differ from the first ones")] = {}
    map: Annotated[
        str,
        Meta(description="plan: of the world; moved: with its furniture elsewhere; other: of another world"),
    ] = "plan"
    keep: Annotated[
        bool, Meta(description="keep the particles of the filter that runs on this map, if there is one")
    ] = False


class LocalizationMessage(Struct, tag_field="type", tag="localization"):
    """Estimate of the particle filter; in a simulation, with its error."""

    is_on: Annotated[bool, Meta(description="whether the robot is localized")]
    map: Annotated[str, Meta(description="of a simulation: plan, moved or other, as the command localize has it")]
    values: Annotated[Values, Meta(description="localization parameters that differ from the first ones")]
    pose: Annotated[Pose | None, Meta(description="the best estimate")]
    at: Annotated[Pose | None, Meta(description="the pose, in a simulation the true one, that it is an estimate of")]
    covariance: Annotated[
        tuple[float, float, float, float] | None,
        Meta(
            description="variances of the estimate: xx, xy, yy in m², yaw in rad²",
            extra={"labels": ("xx", "xy", "yy", "yaw")},
        ),
    ]
    is_converged: Annotated[bool, Meta(description="whether the particles agree on one place")]
    is_sure: Annotated[bool, Meta(description="whether other places in the map were ruled out, too")]
    share: Annotated[float, Meta(description="weight of the heaviest cluster, 0 to 1")]
    fit: Annotated[float, Meta(description="how well the last scan that was used fits, 0 to 1")]
    entropy: Annotated[float, Meta(description="of the histogram of particles in bins of 0.5 m and 10°, bits")]
    n_particles: Annotated[int, Meta(description="number of particles")]
    n_updates: Annotated[int, Meta(description="scans that were used")]
    error_m: Annotated[float | None, Meta(description="distance of the estimate from the true pose, m")]
    error_rad: Annotated[float | None, Meta(description="its error in heading, rad")]


def rounded_pose(pose: Iterable[float]) -> tuple[float, float, float]:
    """Return a pose, rounded for messages."""
    x, y, yaw = (round(float(value), 4) for value in pose)
    return x, y, yaw


def rounded_covariance(c: Float64Array) -> tuple[float, float, float, float]:
    """Return a covariance (3, 3), rounded for messages: xx, xy, yy in m², yaw in rad²."""
    xx, xy, yy, yaw = (round(float(value), 6) for value in (c[0, 0], c[0, 1], c[1, 1], c[2, 2]))
    return xx, xy, yy, yaw


#: for a session without a filter
OFF = LocalizationMessage(
    is_on=False, map="plan", values={}, pose=None, at=None, covariance=None, is_converged=False, is_sure=False,
    share=0.0, fit=0.0, entropy=0.0, n_particles=0, n_updates=0, error_m=None, error_rad=None,
)  # fmt: skip
COMMANDS = (LocalizeCommand,)
MESSAGES = (LocalizationMessage,)
