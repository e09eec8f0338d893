"""File of a localization's filter states: the uncertainty of each pose, the particles, and the map."""

from __future__ import annotations

import io
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from mapper.core.array_types import Float64Array
from mapper.core.errors import ReadError
from server.library.packs.arrays import UNREADABLE, compressed_arrays
from server.library.packs.reference_map import ReferenceMap

MOST_ROWS = 300_000  #: particles stored for all scans together


_UNREADABLE = "The file of this localization cannot be read; localize the log again."

_ARRAYS = (
    "covariance", "is_converged", "is_sure", "is_updated", "share", "fit", "entropy", "n_particles", "offsets",
    "particles",
)  # fmt: skip


@dataclass(frozen=True, slots=True, eq=False)
class FilterStates:
    """For each of n scans, the values of :class:`mapper.localization.Localized`, and a sample of the particles.

    The particles of the k-th used scan are the rows ``offsets[k]`` to ``offsets[k + 1]`` of ``particles`` (m, 3)
    float32. ``covariance`` is (n, 3, 3).
    """

    covariance: Float64Array
    is_converged: NDArray[np.bool_]
    is_sure: NDArray[np.bool_]
    is_updated: NDArray[np.bool_]
    share: Float64Array
    fit: Float64Array
    entropy: Float64Array
    n_particles: NDArray[np.int64]
    offsets: NDArray[np.int64]
    particles: NDArray[np.float32]
    reference: ReferenceMap

    def cloud(self, scan: int) -> NDArray[np.float32]:
        """Return the particles (k, 3) after a scan: those of the last used scan up to it."""
        k = int(np.count_nonzero(self.is_updated[: scan + 1])) - 1
        return self.particles[self.offsets[k] : self.offsets[k + 1]] if k >= 0 else self.particles[:0]


def thinned(clouds: list[NDArray[np.float32]]) -> tuple[NDArray[np.int64], NDArray[np.float32]]:
    """Return offsets and rows of ``clouds``, every k-th row if there are more than :data:`MOST_ROWS`."""
    step = max(1, -(-sum(map(len, clouds)) // MOST_ROWS))
    samples = [cloud[::step] for cloud in clouds]
    offsets = np.concatenate([[0], np.cumsum([len(cloud) for cloud in samples])]).astype(np.int64)
    return offsets, np.concatenate(samples) if samples else np.empty((0, 3), dtype=np.float32)


def filter_states_bytes(states: FilterStates) -> bytes:
    """Return the file of a filter's states."""
    return compressed_arrays({name: getattr(states, name) for name in _ARRAYS} | states.reference.arrays())


def read_converged(path: Path) -> NDArray[np.bool_]:
    """Return from a file at which scans (n,) the filter had converged. Raises like :func:`read_filter_states`."""
    try:
        with np.load(path, allow_pickle=False) as arrays:
            converged: NDArray[np.bool_] = arrays["is_converged"]
            return converged
    except UNREADABLE as error:
        raise ReadError("localization.file", _UNREADABLE) from error


def read_filter_states(data: bytes) -> FilterStates:
    """Return what was passed to :func:`filter_states_bytes`. Raises :class:`ReadError` for anything else."""
    try:
        with np.load(io.BytesIO(data), allow_pickle=False) as arrays:
            arrays_ = {name: arrays[name] for name in _ARRAYS if name in arrays}
            # In an older file without this field, no scan counts as sure.
            arrays_.setdefault("is_sure", np.zeros(len(arrays_["is_converged"]), dtype=np.bool_))
            return FilterStates(**arrays_, reference=ReferenceMap.of_arrays(arrays))
    except UNREADABLE as error:
        raise ReadError("localization.file", _UNREADABLE) from error
