"""The stream's command and message of a terrain."""

from __future__ import annotations

from typing import Annotated

from msgspec import Meta, Struct

from server.stream.message_parts import Number, Part, Point, UncheckedValues, Values


class TerrainCommand(Struct, tag_field="type", tag="terrain"):
    """Simulations with a 3D map, and clouds: begin to assess their terrain, change it, query a patch, or end."""

    value: Annotated[bool, Meta(description="whether it is assessed")] = True
    values: Annotated[UncheckedValues, Meta(description="parameters to change; the others stay")] = {}
    x: Annotated[Number | None, Meta(description="x of a place in the patch that is asked about, m; null: none")] = None
    y: Annotated[Number | None, Meta(description="y of that place, m")] = None


class TerrainCounts(Part):
    """Numbers of patches of each class before the last change of parameters."""

    changed: Annotated[list[str], Meta(description="names of the parameters")]
    safe: Annotated[int, Meta(description="patches that were safe")]
    unsafe: Annotated[int, Meta(description="patches that were unsafe")]
    unknown: Annotated[int, Meta(description="patches with too few points")]


class TerrainPatch(Part):
    """A queried patch of terrain, or the window around it to which its plane is fitted."""

    x: Annotated[float, Meta(description="the place that was asked about, m")]
    y: Annotated[float, Meta(description="the place that was asked about, m")]
    centre: Annotated[Point, Meta(description="its centre, m")]
    half: Annotated[float, Meta(description="half of its side, m")]
    base: Annotated[float, Meta(description="the height above which its heights are, m")]
    moments: Annotated[
        list[float], Meta(description="P, 4 × 4 row by row: the sum of v vᵀ with v = [1 x y z]ᵀ about its centre")
    ]
    n: Annotated[int, Meta(description="its ground points, with those that RANSAC leaves out")]
    points: Annotated[
        list[float], Meta(description="x, y, z of these points about its centre, m; of many every second one, or fewer")
    ]
    edges: Annotated[
        list[float],
        Meta(
            description="x, y, z in the middle of each edge, z on the plane of the neighbour there, of those with one"
        ),
    ]
    children: Annotated[
        list[list[float]],
        Meta(description="P of its four children in the quadtree, about its centre; empty: it has none"),
    ]
    why: Annotated[str, Meta(description="why it has its class, one sentence")]
    state: Annotated[str, Meta(description="safe, unsafe or unknown")]


class TerrainMessage(Struct, tag_field="type", tag="terrain"):
    """The terrain of a simulation or a cloud, in the layers `terrain_costs` and `terrain_values`."""

    is_on: Annotated[bool, Meta(description="whether it is assessed")]
    values: Annotated[Values, Meta(description="its parameters")]
    points: Annotated[int, Meta(description="points that it is made of")]
    ground: Annotated[int, Meta(description="those that the filter takes for ground")]
    unsure: Annotated[int, Meta(description="points of which the filter is not sure")]
    left_out: Annotated[int, Meta(description="ground points that RANSAC leaves out of the planes")]
    kappa: Annotated[
        float | None, Meta(description="Cohen's kappa of ground and objects, %; null: the truth is not known")
    ]
    total_error: Annotated[float | None, Meta(description="points that are classified wrongly, %; null: as above")]
    truth: Annotated[str | None, Meta(description="what they are compared with; null: as above")]
    safe: Annotated[int, Meta(description="patches that are safe")]
    unsafe: Annotated[int, Meta(description="patches that are unsafe")]
    unknown: Annotated[int, Meta(description="patches with too few points")]
    size: Annotated[float, Meta(description="side of a patch, m")]
    before: Annotated[
        TerrainCounts | None,
        Meta(description="the classes before the newest change of parameters; null: there was none"),
    ]
    patch: Annotated[TerrainPatch | None, Meta(description="the patch that was asked about; null: none was")]
    problem: Annotated[str | None, Meta(description="why it cannot be assessed, one sentence; null: it is")]


COMMANDS = (TerrainCommand,)
MESSAGES = (TerrainMessage,)
