"""Construction of the costmap described by a parameter file."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path, PureWindowsPath
from typing import TypeAlias, TypeVar

from mapper.core.array_types import Int8Array, UInt8Array
from mapper.core.errors import ConfigError, LimitError, ReadError
from mapper.costmap.costs import name_of_cost
from mapper.costmap.decay_layer import DecayLayer
from mapper.costmap.denoise_layer import DenoiseLayer
from mapper.costmap.footprint import Footprint
from mapper.costmap.given_layer import GivenLayer
from mapper.costmap.keepout_layer import KeepoutLayer
from mapper.costmap.kernels.observation import lay_over
from mapper.costmap.layered import LayeredCostmap
from mapper.costmap.layers import InflationLayer, Layer, ObstacleLayer, Robot, StaticLayer, part_of
from mapper.costmap.masks import Mask
from mapper.costmap.nav2.costmap import ContainerConfig, NamedLayer, Nav2Costmap
from mapper.costmap.parameters import (
    COMBINATIONS,
    CostmapConfig,
    DecayConfig,
    DenoiseConfig,
    GivenConfig,
    InflationConfig,
    ObstacleConfig,
    StaticConfig,
    VoxelConfig,
)
from mapper.costmap.speed_filter import SpeedFilter
from mapper.costmap.voxel_layer import VoxelLayer, heights_of
from mapper.grid.cell_box import CellBox
from mapper.grid.occupancy_grid import GridGeometry
from mapper.io.maps import load_map


class ContainerLayer:
    """The combined costs of ``inner``, applied as one layer; NO_INFORMATION where none of its layers has information.

    Its inflation spreads around its own obstacles only. Source: nav2_costmap_2d, plugin_container_layer.cpp. There the
    costs are not reset before an update, so with a method that keeps the greater cost they never decrease; here they
    do.
    """

    def __init__(self, inner: LayeredCostmap, combination_method: str, name: str) -> None:
        self.name, self._inner = name, inner
        self._method = COMBINATIONS.index(combination_method)

    @property
    def costs(self) -> UInt8Array:
        """The combined costs (rows, cols) of its layers."""
        return self._inner.costs

    def changed(self, now: float, robot: Robot | None) -> CellBox | None:
        """Update its layers; return the box that changed."""
        return self._inner.update(now, None if robot is None else robot.pose)

    def lay(self, master: UInt8Array, box: CellBox) -> None:
        """Combine the costs with the master by ``combination_method``."""
        lay_over(self.costs[part_of(box)], self._method, master[part_of(box)])

    def why(self, row: int, col: int) -> str:
        """Describe the combined cost of its layers, and the cost of each."""
        reasons = " ".join(f"{cost.layer}: {cost.sentence}" for cost in self._inner.why(row, col))
        return f"Its layers make {name_of_cost(int(self.costs[row, col]))} together. {reasons}"


DEFAULT = Nav2Costmap(
    "global_costmap",
    CostmapConfig(),
    None,
    (NamedLayer("static_layer", StaticConfig()), NamedLayer("inflation_layer", InflationConfig())),
)  #: Nav2's costmap of a map without a parameter file


ObservedLayer = ObstacleLayer | VoxelLayer | DecayLayer
L = TypeVar("L", ObstacleLayer, VoxelLayer, DecayLayer, GivenLayer)
_BelowInflation: TypeAlias = "StaticConfig | ObstacleConfig | DenoiseConfig | GivenConfig | ContainerConfig"


@dataclass(frozen=True, slots=True)
class BuiltCostmap:
    """A costmap, with those of its layers that accept observations, painting, costs or queries.

    ``unmasked`` are the names of filters without a mask, which have no effect. ``given`` are layers, by name, whose
    costs have to be set; without costs they have no effect. ``observed`` are the names of ``obstacles``, ``statics``
    the layers of the map. ``layers`` are all layers that were built, by name.
    """

    costmap: LayeredCostmap
    obstacles: tuple[ObservedLayer, ...]
    keepout: KeepoutLayer
    speed: tuple[SpeedFilter, ...] = ()
    unmasked: tuple[str, ...] = field(default=())
    given: Mapping[str, GivenLayer] = field(default_factory=dict)
    observed: tuple[str, ...] = ()
    statics: tuple[StaticLayer, ...] = ()
    layers: Mapping[str, Layer | InflationLayer] = field(default_factory=dict)


def load_masks(parameters: Nav2Costmap, folder: Path, frame: str | None = None) -> dict[str, Mask]:
    """Return the masks of the parameters' filters by filter name; file names are relative to ``folder``.

    The name of a filter in a container is prefixed with that of the container and a dot. A mask may differ from the map
    in resolution and origin. ``frame`` is the map's, if known. Raises :class:`mapper.core.errors.ReadError` for a mask
    that cannot be read, and :class:`ConfigError` for a mask file that states another frame, because its pose in the
    map's frame is unknown.
    """
    masks: dict[str, Mask] = {}
    for layer in parameters.layers:
        if isinstance(layer.config, ContainerConfig):
            inner = load_masks(layer.config.inner, folder, frame)
            masks |= {f"{layer.name}.{name}": mask for name, mask in inner.items()}
    for filter_ in parameters.filters:
        if filter_.mask is not None and filter_.kind != "binary":
            path, note = _mask_path(folder, filter_.mask)
            try:
                loaded = load_map(path)
            except ReadError as error:
                raise ReadError(
                    error.code, f"The mask {filter_.mask!r:.120} of {filter_.name}: {error.message}"
                ) from error
            stated = loaded.description.frame
            if frame is not None and stated is not None and frame.strip("/") != stated.strip("/"):
                raise ConfigError(
                    "costmap.frame",
                    f"The mask {filter_.mask!r:.80} of {filter_.name} is in the frame {stated!r:.80}, the map in "
                    f"{frame!r:.80}: all layers must be in one frame.",
                )
            masks[filter_.name] = Mask(loaded.grid.geometry, loaded.values, (*note, *loaded.notes))
    return masks


def _mask_path(folder: Path, name: str) -> tuple[Path, tuple[str, ...]]:
    """Return the path of a mask's yaml; for a path elsewhere, the file of the same name in ``folder``, with a note.

    Parameter files refer to masks by a path on the robot, or by ``$(find-pkg-share …)``.
    """
    named, beside = folder / name, folder / PureWindowsPath(name).name
    if "\0" in name or named.is_file() or not beside.is_file():
        return named, ()
    note = f"{beside.name!r:.80} beside the parameter file is read in its place."
    return beside, (f"The parameter file names the mask {name!r:.120}; {note}",)


def build_costmap(
    geometry: GridGeometry,
    values: Int8Array,
    parameters: Nav2Costmap = DEFAULT,
    footprint: Footprint | None = None,
    masks: Mapping[str, Mask] | None = None,
    keepout: KeepoutLayer | None = None,
    kept: Sequence[ObservedLayer | GivenLayer] = (),
) -> BuiltCostmap:
    """Return the costmap of a map with the layers and filters of ``parameters``, and a keepout layer to paint on.

    ``values`` (rows, cols) int8 are those of nav_msgs/OccupancyGrid. ``footprint`` replaces the parameters' padded
    outline. ``masks`` are those of the filters, by name. The painted keepout layer is below the inflation. Filters are
    at their position in the parameters; those in Nav2's list of filters are above all layers. Disabled layers are built
    but not applied. ``keepout`` is an existing painted layer, and ``kept`` are existing layers over the same geometry
    with observations or costs: the first layer of each kind reuses the first of them, with its new parameters. Raises
    :class:`ConfigError` for two inflation layers.
    """
    outline = footprint or parameters.outline
    if keepout is None:
        keepout = KeepoutLayer(geometry, name="painted_keepout" if _has_keepouts(parameters) else "keepout_filter")
    builder = _Builder(geometry, values, outline, masks or {}, kept)
    built = builder.stack(parameters, parameters.general, keepout)
    return BuiltCostmap(
        built, tuple(builder.obstacles), keepout, tuple(builder.speed), tuple(builder.unmasked), builder.given,
        tuple(builder.observed), tuple(builder.statics), builder.layers,
    )  # fmt: skip


class _Builder:
    """Builds costmaps of layers over one map, and keeps the layers that accept observations, costs or queries."""

    def __init__(
        self,
        geometry: GridGeometry,
        values: Int8Array,
        outline: Footprint,
        masks: Mapping[str, Mask],
        kept: Sequence[ObservedLayer | GivenLayer],
    ) -> None:
        self.geometry, self.values, self.outline, self.masks = geometry, values, outline, masks
        self._kept = [*kept]
        self.statics: list[StaticLayer] = []
        self.layers: dict[str, Layer | InflationLayer] = {}
        self.obstacles: list[ObservedLayer] = []
        self.observed: list[str] = []
        self.given: dict[str, GivenLayer] = {}
        self.speed: list[SpeedFilter] = []
        self.unmasked: list[str] = []

    def stack(
        self, parameters: Nav2Costmap, general: CostmapConfig, painted: KeepoutLayer | None, within: str = ""
    ) -> LayeredCostmap:
        """Return the layers of ``parameters`` in order, with ``painted`` below the inflation.

        ``within`` is the prefix of their names. Raises :class:`ConfigError` for two inflation layers.
        """
        below: list[Layer] = []
        above: list[Layer] = []
        inflation: InflationLayer | None = None
        for k, named in enumerate(parameters.layers):
            place = below if inflation is None else above
            place += self._keepouts(parameters, k, within)
            config, name = named.config, within + named.name
            if isinstance(config, InflationConfig):
                if inflation is not None:
                    raise ConfigError("costmap.inflation", "A costmap can have one inflation layer only.")
                below += [painted] if painted is not None else []
                self.layers[name] = made = self._inflation(config, f"{parameters.node}.{named.name}")
                inflation = made if config.enabled else None
            else:
                layer = self._layer(config, name, parameters.general, general)
                self.layers[name] = layer
                if config.enabled:
                    place.append(layer)
        if inflation is None and painted is not None:
            below.append(painted)
        place = below if inflation is None else above
        place += self._keepouts(parameters, len(parameters.layers), within)
        place += self._keepouts(parameters, None, within)
        for filter_ in parameters.filters:
            mask = self.masks.get(within + filter_.name)
            if mask is None:
                self.unmasked.append(within + filter_.name)
            elif filter_.kind == "speed" and filter_.enabled:
                self.speed.append(SpeedFilter(mask, filter_.type, filter_.base, filter_.multiplier))
        return LayeredCostmap(self.geometry, general, self.outline, below, inflation, above)

    def _layer(self, config: _BelowInflation, name: str, own: CostmapConfig, general: CostmapConfig) -> Layer:
        """Return the layer for the parameters ``own``; ``general`` are those of the costmap or of the container."""
        if isinstance(config, StaticConfig):
            self.statics.append(StaticLayer(self.geometry, self.values, config, own))
            return self.statics[-1]
        if isinstance(config, DenoiseConfig):
            return DenoiseLayer(self.geometry, config, own, name)
        if isinstance(config, GivenConfig):
            given = self._kept_one(GivenLayer) or GivenLayer(self.geometry, name)
            if config.enabled:
                self.given[name] = given
            return given
        if isinstance(config, ContainerConfig):
            inner = self.stack(config.inner, replace(general, track_unknown_space=True), None, f"{name}.")
            return ContainerLayer(inner, config.combination_method, name)
        layer = self._observed(config, own)
        self.obstacles.append(layer)
        self.observed.append(name)
        return layer

    def _observed(self, config: ObstacleConfig, general: CostmapConfig) -> ObservedLayer:
        if isinstance(config, DecayConfig):
            decay = self._kept_one(DecayLayer) or DecayLayer(self.geometry, config, general)
            decay.configure(config)
            return decay
        if isinstance(config, VoxelConfig):
            voxels = self._kept_one(VoxelLayer)
            if voxels is None or voxels.heights != heights_of(config):
                voxels = VoxelLayer(self.geometry, config, general)
            voxels.configure(config)
            return voxels
        layer = self._kept_one(ObstacleLayer) or ObstacleLayer(self.geometry, config, general)
        layer.configure(config)
        return layer

    def _kept_one(self, kind: type[L]) -> L | None:
        """Remove and return the first kept layer of a kind; None if there is none."""
        for layer in self._kept:
            if isinstance(layer, kind):
                self._kept.remove(layer)
                return layer
        return None

    def _inflation(self, config: InflationConfig, path: str) -> InflationLayer:
        """Return the layer. ``path`` is its place in a parameter file, for the error about a radius of too many
        cells.
        """
        try:
            return InflationLayer(self.geometry, config, self.outline.inscribed_radius)
        except LimitError as error:
            raise LimitError(error.code, f"{path}.inflation_radius: {error.message}") from error

    def _keepouts(self, parameters: Nav2Costmap, n_below: int | None, within: str) -> Iterator[KeepoutLayer]:
        """Yield the enabled keepout filters of ``parameters`` that have a mask and are above ``n_below`` layers."""
        for filter_ in parameters.filters:
            name = within + filter_.name
            if filter_.kind == "keepout" and filter_.below == n_below and filter_.enabled and name in self.masks:
                yield KeepoutLayer(self.geometry, self.masks[name], name)


def _has_keepouts(parameters: Nav2Costmap) -> bool:
    return any(filter_.kind == "keepout" for filter_ in parameters.filters)
