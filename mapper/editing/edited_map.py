"""A map with its edits, which can be undone."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any, TypeAlias

import numpy as np
from numpy.typing import NDArray
from scipy import ndimage
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

from mapper.core.array_types import Float64Array, Int8Array, Int64Array
from mapper.core.errors import ConfigError, LimitError, WorkCancelledError
from mapper.core.se2 import compose, inverse, transform_points
from mapper.editing.areas import Covered, polygon_cells, row_bands, stroke_cells
from mapper.editing.operations import (
    VALUES,
    Crop,
    Despeckle,
    Fill,
    Keepout,
    Operation,
    Origin,
    Paint,
    Rotate,
    Speed,
)
from mapper.grid.occupancy_grid import GridGeometry

MAX_EDITS = 2000
_EVERY = 20  #: edits between two stored states,
_COSTLY = (Rotate, Despeckle)  #: and slow edits of the whole map, after which the state is also stored
_LEAST_KEPT = 3  #: states
MOST_KEPT_CELLS = 1 << 26  #: of all stored states
_AT_ONCE = 1 << 16  #: cells rotated at a time
_EDGE = 1e-6  #: cells; so that rounding errors of a rotation by 90° do not add a row

Check: TypeAlias = "Callable[[], None]"  #: called between two parts of an edit; raises an error to cancel the edit


@dataclass(frozen=True, slots=True)
class _State:
    """A map between two edits: ``values``, ``keepout`` and ``speed`` (rows, cols) int8; they are not modified."""

    geometry: GridGeometry
    values: Int8Array
    keepout: Int8Array
    speed: Int8Array


class EditedMap:
    """A map of ``values`` (rows, cols) int8, 0 … 100 or −1 unknown as in nav_msgs/OccupancyGrid, and its edits.

    ``keepout`` (rows, cols) int8 are the values of a keepout mask, 0 if nothing is forbidden, and ``speed`` those of a
    speed filter's mask, 0 for no limit; None: 0 everywhere. ``may_continue`` is called about every hundredth of a
    second during an edit; if it returns False, the edit raises :class:`WorkCancelledError`, and nothing has changed.
    """

    def __init__(
        self,
        geometry: GridGeometry,
        values: Int8Array,
        keepout: Int8Array | None = None,
        may_continue: Callable[[], bool] = lambda: True,
        *,
        speed: Int8Array | None = None,
    ) -> None:
        if values.shape != geometry.shape:
            raise ConfigError("edit.shape", f"The map has {values.shape} values for {geometry.shape} cells.")
        masks = _mask(geometry, keepout, "keepout mask"), _mask(geometry, speed, "speed mask")
        first = _State(geometry, values.astype(np.int8), *masks)
        self._may_continue = may_continue
        self._kept: dict[int, _State] = {0: first}
        self._state = first
        self._operations: list[Operation] = []
        self._n = 0

    @property
    def geometry(self) -> GridGeometry:
        """Geometry of the map."""
        return self._state.geometry

    @property
    def values(self) -> Int8Array:
        """The values (rows, cols) after all edits that are not undone."""
        return self._state.values

    @property
    def keepout(self) -> Int8Array:
        """The keepout mask (rows, cols)."""
        return self._state.keepout

    @property
    def speed(self) -> Int8Array:
        """The speed filter's mask (rows, cols)."""
        return self._state.speed

    @property
    def source(self) -> GridGeometry:
        """Geometry of the map before the first edit."""
        return self._kept[0].geometry

    @property
    def operations(self) -> Sequence[Operation]:
        """The edits that are not undone, in order."""
        return tuple(self._operations[: self._n])

    @property
    def can_redo(self) -> bool:
        """Whether an edit was undone and none was made since."""
        return self._n < len(self._operations)

    @property
    def n_undone(self) -> int:
        """Number of undone edits."""
        return len(self._operations) - self._n

    @property
    def cells(self) -> int:
        """Number of cells of all states stored for undoing."""
        return sum(3 * state.values.size for state in self._kept.values())

    def apply(self, operation: Operation) -> None:
        """Apply an edit; edits undone before are discarded.

        Raises :class:`ConfigError` for an edit that leaves no cell or has no effect, and :class:`LimitError` for more
        than 2,000 edits; nothing has changed then.
        """
        if self._n >= MAX_EDITS:
            raise LimitError(
                "edit.too_many", f"A map can have at most {MAX_EDITS} edits; save it, and edit the result."
            )
        self._state = self._after(self._state, operation)
        del self._operations[self._n :]
        self._operations.append(operation)
        self._n += 1
        for n in [n for n in self._kept if n >= self._n]:
            del self._kept[n]
        if self._n % _EVERY == 0 or isinstance(operation, _COSTLY):
            self._kept[self._n] = self._state
            self._drop_states()

    def undo(self, steps: int = 1) -> bool:
        """Undo the last ``steps`` edits, or all if there are fewer; return whether there was one."""
        if self._n == 0:
            return False
        self._go_to(max(self._n - steps, 0))
        return True

    def redo(self, steps: int = 1) -> bool:
        """Redo the last ``steps`` undone edits, or all; return whether there was one."""
        if not self.can_redo:
            return False
        self._go_to(min(self._n + steps, len(self._operations)))
        return True

    def _drop_states(self) -> None:
        """Drop stored states, except the first, until they have few cells; the older of two neighbours is dropped."""
        while len(self._kept) > _LEAST_KEPT and self.cells > MOST_KEPT_CELLS:
            numbers = sorted(self._kept)
            gaps = [after - before for before, after in itertools.pairwise([*numbers, self._n + _EVERY])]
            del self._kept[numbers[1 + min(range(len(gaps) - 1), key=lambda k: gaps[k] + gaps[k + 1])]]

    def _go_to(self, n: int) -> None:
        states = {**self._kept, self._n: self._state}
        begin = max(k for k in states if k <= n)
        state = states[begin]
        for operation in self._operations[begin:n]:
            state = self._after(state, operation)
        self._state, self._n = state, n

    def _after(self, state: _State, operation: Operation) -> _State:
        self._check()
        return _APPLY[type(operation)](state, operation, self._check)

    def _check(self) -> None:
        if not self._may_continue():
            raise WorkCancelledError("edit.cancelled", "The edit was cancelled.")


def _mask(geometry: GridGeometry, mask: Int8Array | None, what: str) -> Int8Array:
    if mask is None:
        return np.zeros(geometry.shape, dtype=np.int8)
    if mask.shape != geometry.shape:
        raise ConfigError("edit.shape", f"The {what} has {mask.shape} values for {geometry.shape} cells.")
    return mask.astype(np.int8)


def _from_lattice(geometry: GridGeometry, lattice: list[tuple[float, float]]) -> Float64Array:
    """Convert lattice coordinates (n, 2), (column, row), to map points (n, 2)."""
    return transform_points(geometry.origin, np.array(lattice, dtype=np.float64) * geometry.resolution)


def _with(old: Int8Array, covered: Covered | None, value: int, what: str) -> Int8Array:
    if covered is None:
        raise ConfigError("edit.outside", f"{what} is outside the map.")
    box, bands = covered
    new = old.copy()
    part = new[box.row0 : box.row1, box.col0 : box.col1]
    for row0, cells in bands:
        part[row0 : row0 + len(cells)][cells] = value
    return new


def _paint(state: _State, edit: Paint, check: Check) -> _State:
    covered = stroke_cells(state.geometry, np.array(edit.points), edit.width, check)
    return replace(state, values=_with(state.values, covered, VALUES[edit.state], "The stroke"))


def _fill(state: _State, edit: Fill, check: Check) -> _State:
    covered = polygon_cells(state.geometry, np.array(edit.polygon), check)
    return replace(state, values=_with(state.values, covered, VALUES[edit.state], "The area"))


def _keepout(state: _State, edit: Keepout, check: Check) -> _State:
    covered = polygon_cells(state.geometry, np.array(edit.polygon), check)
    return replace(state, keepout=_with(state.keepout, covered, int(edit.value), "The keepout zone"))


def _speed(state: _State, edit: Speed, check: Check) -> _State:
    covered = polygon_cells(state.geometry, np.array(edit.polygon), check)
    return replace(state, speed=_with(state.speed, covered, int(edit.value), "The zone with a speed limit"))


def _despeckle(state: _State, edit: Despeckle, check: Check) -> _State:
    return replace(state, values=without_specks(state.values, edit.cells, check))


def _rotate(state: _State, edit: Rotate, check: Check) -> _State:
    old = state.geometry
    x, y, yaw = compose((0.0, 0.0, edit.angle), old.origin)
    turned = GridGeometry(old.resolution, old.rows, old.cols, (float(x), float(y), float(yaw)), old.limits)
    corners = _from_lattice(turned, [(u, v) for u in (0.0, old.cols) for v in (0.0, old.rows)])
    low = corners.min(axis=0)
    cols, rows = (max(1, math.ceil(side - _EDGE)) for side in (corners.max(axis=0) - low) / old.resolution)
    new = GridGeometry(old.resolution, rows, cols, (float(low[0]), float(low[1]), 0.0), old.limits)
    values: Int8Array = np.full(new.shape, VALUES["unknown"], dtype=np.int8)
    masks = tuple(np.zeros(new.shape, dtype=np.int8) for _ in range(2))
    for begin in range(0, values.size, _AT_ONCE):
        check()
        flat = np.arange(begin, min(begin + _AT_ONCE, values.size))
        at = turned.world_to_cell(new.cell_to_world(np.column_stack(np.divmod(flat, cols))))
        is_inside = ((at >= 0) & (at < old.shape)).all(axis=1)
        source = at[is_inside, 0], at[is_inside, 1]
        values.reshape(-1)[flat[is_inside]] = state.values[source]
        for mask, old_mask in zip(masks, (state.keepout, state.speed), strict=True):
            mask.reshape(-1)[flat[is_inside]] = old_mask[source]
    return _State(new, values, *masks)


def _crop(state: _State, edit: Crop, _: Check) -> _State:
    (x0, y0), (x1, y1) = edit.corners
    box = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
    old = state.geometry
    lattice = old.to_lattice(box)
    col0, row0 = (int(v) for v in np.maximum(np.floor(lattice.min(axis=0) + _EDGE), 0))
    col1, row1 = (int(v) for v in np.minimum(np.ceil(lattice.max(axis=0) - _EDGE), (old.cols, old.rows)))
    if row0 >= row1 or col0 >= col1:
        raise ConfigError("edit.empty", "The rectangle contains no cell of the map.")
    x, y = (float(value) for value in _from_lattice(old, [(col0, row0)])[0])
    new = GridGeometry(old.resolution, row1 - row0, col1 - col0, (x, y, old.origin[2]), old.limits)
    part = np.s_[row0:row1, col0:col1]
    return _State(new, *(cells[part].copy() for cells in (state.values, state.keepout, state.speed)))


def _origin(state: _State, edit: Origin, _: Check) -> _State:
    old = state.geometry
    x, y, yaw = (float(v) for v in compose(inverse((edit.x, edit.y, edit.yaw)), old.origin))
    return replace(state, geometry=GridGeometry(old.resolution, old.rows, old.cols, (x, y, yaw), old.limits))


_APPLY: dict[type[Operation], Callable[[_State, Any, Check], _State]] = {
    Paint: _paint, Fill: _fill, Keepout: _keepout, Speed: _speed, Despeckle: _despeckle, Rotate: _rotate, Crop: _crop,
    Origin: _origin,
}  # fmt: skip


_TOUCHING = np.ones((3, 3))  #: cells touch by sides or corners


def without_specks(values: Int8Array, cells: float, check: Callable[[], None]) -> Int8Array:
    """Return ``values`` (rows, cols) with groups of at most ``cells`` occupied cells set to free.

    ``check`` is called before each band of rows. The groups of a band are found separately; those that touch across the
    border of two bands are then joined.
    """
    rows, cols = values.shape
    bands = [*row_bands(rows, cols)]
    groups = np.zeros(values.shape, dtype=np.int32)
    sizes = [np.zeros(1, dtype=np.int64)]  # group 0 means no group
    n_groups = 0
    for row0, row1 in bands:
        check()
        labels, n_found = ndimage.label(values[row0:row1] == VALUES["occupied"], structure=_TOUCHING)
        sizes.append(np.bincount(labels.ravel(), minlength=n_found + 1)[1:])
        groups[row0:row1] = np.where(labels > 0, labels + n_groups, 0)
        n_groups += n_found
    n_cells = np.concatenate(sizes)
    pairs = [_touching(groups[row0 - 1], groups[row0]) for _, (row0, _) in pairwise(bands)]
    if pairs:
        check()
        _add_joined(n_cells, np.concatenate(pairs))
    small = n_cells <= cells
    small[0] = False
    new = values.copy()
    for row0, row1 in bands:
        check()
        new[row0:row1][small[groups[row0:row1]]] = VALUES["free"]
    return new


def _touching(above: NDArray[np.int32], below: NDArray[np.int32]) -> NDArray[np.int32]:
    """Return the pairs (n, 2) of groups that touch across the border of two rows of groups (cols,)."""
    cols = len(above)
    pairs = [
        np.column_stack((above[max(shift, 0) : cols + min(shift, 0)], below[max(-shift, 0) : cols - max(shift, 0)]))
        for shift in (-1, 0, 1)
    ]
    every = np.concatenate(pairs)
    return every[(every > 0).all(axis=1)]


def _add_joined(n_cells: Int64Array, pairs: NDArray[np.int32]) -> None:
    """Add to each group of ``pairs`` (n, 2) the cells of all groups joined with it; ``n_cells`` is modified."""
    joined, at = np.unique(pairs, return_inverse=True)
    first, second = at.reshape(-1, 2).T
    n = len(joined)
    links = coo_array((np.ones(len(first), dtype=np.int8), (first, second)), shape=(n, n))
    _, component = connected_components(links, directed=False)
    total = np.bincount(component, weights=n_cells[joined])
    n_cells[joined] = total[component].astype(np.int64)
