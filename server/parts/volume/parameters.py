"""The parameters of the lab's 3D map: of its sensor, of the map, and of its display."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from typing import Any

from mapper.core.errors import ConfigError
from mapper.core.parameter import Parameter, check_names
from mapper.simulation.sensors_3d import SENSOR_3D_PARAMETERS, Sensor3D
from mapper.volume import TsdfConfig, VolumeConfig
from mapper.volume.surface.parameters import TSDF_PARAMETERS
from server.parts.volume.look import COLOURS as RAMP
from server.parts.volume.look import CUTS, LOOK_PARAMETERS, Look

LOWEST, HIGHEST = -0.3, 2.4  #: metres: of the voxels of the lab's worlds
COLOURS = ("height", "belief", "normal")
KINDS = ("occupancy", "tsdf")
#: The surface uses the map's voxels and the sensor's range; its truncation is at most this long, metres.
_NOT_OF_SURFACE, _LONGEST_TRUNCATION = ("resolution", "range_max"), 2.0

_OF_CLIP_BOX = (*CUTS, "cut_handles")
_HEIGHTS_FIRST = {"cut_low": 0.1, "cut_high": 1.5}  #: excludes the floor and the lintels of doors, metres


def _of_surface(row: Parameter) -> Parameter:
    return replace(row, group="tsdf_3d", high=_LONGEST_TRUNCATION if row.name == "truncation" else row.high)


def _of_clip_box(row: Parameter) -> Parameter:
    """Return the row for the lab. Those of x and y are not bound to a world, because it may be replaced."""
    if row.name not in _HEIGHTS_FIRST:
        return replace(row, group="clip_3d")
    return replace(row, group="clip_3d", initial=_HEIGHTS_FIRST[row.name], low=LOWEST, high=HIGHEST)


TABLE: tuple[Parameter, ...] = (
    *SENSOR_3D_PARAMETERS,
    Parameter(
        "kind", "Map", "kind_3d", "choice", "occupancy",
        "What is shown, made of the same scans: occupied voxels, or the surface by truncated signed distances (TSDF). "
        "The map from above is always that of the occupied voxels.",
        choices=KINDS,
    ),
    *(_of_surface(row) for row in TSDF_PARAMETERS if row.name not in _NOT_OF_SURFACE),
    Parameter(
        "voxel", "Voxel", "map_3d", "number", 0.1,
        "Side of a voxel. The map is computed again from the recorded scans.",
        unit="m", low=0.05, high=0.5, step=0.05,
    ),
    Parameter(
        "half_life", "Half-life", "map_3d", "number", 0.0,
        "Time in which log-odds fall by half, so that what is not seen again is forgotten; 0 is never. The map is "
        "computed again from the recorded scans.",
        unit="s", low=0.0, high=300.0, step=5.0,
    ),
    *(_of_clip_box(row) for row in LOOK_PARAMETERS if row.name in _OF_CLIP_BOX),
    Parameter(
        "colour", "Colour", "view_3d", "choice", "height", "What the colour of a voxel stands for.", choices=COLOURS,
    ),
    Parameter(
        "click", "A click in 3D", "click_3d", "choice", "asks_a_voxel",
        "What a click in a 3D view does: it asks why a voxel has its value, or it places the robot on the floor.",
        choices=("asks_a_voxel", "places_the_robot"),
    ),
    Parameter(
        "band_low", "Band from", "band_3d", "number", 0.1,
        "The least height that the projection has; voxels that hold the floor are left out.",
        unit="m", low=0.0, high=HIGHEST, step=0.05,
    ),
    Parameter(
        "band_high", "Band up to", "band_3d", "number", 0.5,
        "The greatest height that the projection has: the robot is 0.5 m high.",
        unit="m", low=0.05, high=HIGHEST, step=0.05,
    ),
)  # fmt: skip
_ROWS = {row.name: row for row in TABLE}
_OF_THE_SENSOR = frozenset(row.name for row in SENSOR_3D_PARAMETERS)
_FLOOR = 0.55  #: of a voxel: the centres of voxels that contain the floor z = 0 are closer to it than this


@dataclass(frozen=True, slots=True)
class VolumeParameters:
    """The current values. Raises :class:`ConfigError` if the table rejects them."""

    values: Mapping[str, Any] = field(default_factory=lambda: {row.name: row.initial for row in TABLE})

    def with_values(self, values: Mapping[str, Any]) -> VolumeParameters:
        """Return the parameters with other values. Raises :class:`ConfigError`."""
        check_names(values, TABLE, "parameter of the 3D map")
        parameters = replace(self, values={**self.values, **{name: _ROWS[name].check(v) for name, v in values.items()}})
        if parameters.values["band_high"] <= parameters.values["band_low"]:
            raise ConfigError(
                "parameter.band_high",
                f"The band must end above its beginning, {parameters.values['band_low']:g} m, "
                f"not at {parameters.values['band_high']:g} m.",
            )
        parameters.sensor  # noqa: B018 - refuses what the sensor's table refuses
        if parameters.is_surface:
            parameters.surface  # noqa: B018 - refuses a truncation of less than two voxels
        return parameters

    @property
    def sensor(self) -> Sensor3D:
        """The 3D sensor."""
        return Sensor3D(**{name: value for name, value in self.values.items() if name in _OF_THE_SENSOR})

    @property
    def config(self) -> VolumeConfig:
        """Parameters of the map. Beams are cut at the sensor's range, where those without a return end."""
        values = self.values
        return VolumeConfig(resolution=values["voxel"], range_max=values["reach"], half_life=values["half_life"])

    @property
    def is_surface(self) -> bool:
        """Whether the surface is shown instead of the occupied voxels."""
        return bool(self.values["kind"] == "tsdf")

    @property
    def surface(self) -> TsdfConfig:
        """Parameters of the surface. Raises :class:`ConfigError` for a truncation of less than two voxels."""
        values = self.values
        own = {field.name: values[field.name] for field in fields(TsdfConfig) if field.name not in _NOT_OF_SURFACE}
        return TsdfConfig(resolution=values["voxel"], range_max=values["reach"], **own)

    @property
    def look(self) -> Look:
        """The display options with the clip box."""
        colour = "normal" if self.values["colour"] == "normal" else "height"
        return Look(colour=colour, band=HIGHEST / RAMP, **{name: self.values[name] for name in _OF_CLIP_BOX})

    @property
    def band(self) -> tuple[float, float]:
        """The heights of the projection, without voxels that contain the floor, metres."""
        return max(self.values["band_low"], _FLOOR * self.values["voxel"]), self.values["band_high"]
