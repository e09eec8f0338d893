"""Named tuples that the compiled functions of volumes take as arguments."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from mapper.core.array_types import Float32Array, Int32Array, Int64Array


class BlockTable(NamedTuple):
    """A hash table with open addressing: the codes of blocks, −1 where there is none, and the slots of their voxels.

    Both have a length that is a power of two and at least twice the number of blocks.
    """

    codes: Int64Array
    slots: Int32Array


class Box(NamedTuple):
    """A box of voxels: the key of its first voxel and its sides, all multiples of 8."""

    x: int
    y: int
    z: int
    nx: int
    ny: int
    nz: int


class Belief(NamedTuple):
    """The log-odds of voxels (slots, 8, 8, 8), z y x, NaN where unknown; of each block their greatest and how many."""

    table: BlockTable
    values: Float32Array
    maxima: Float32Array
    known: Int32Array


class CastRule(NamedTuple):
    """When a cast ray ends: at log-odds from ``occupied``, at unknown voxels, and beyond ``range_max`` > 0, metres."""

    resolution: float
    occupied: float
    through_unknown: bool
    range_max: float


class Updates(NamedTuple):
    """What a scan adds to the log-odds of voxels, and their limits."""

    miss: np.float32
    hit: np.float32
    least: np.float32
    greatest: np.float32


class FaceRule(NamedTuple):
    """Which voxels are drawn, and in which of ``colours`` colours, from 1.

    Those with log-odds from ``occupied`` and a key z of ``first`` … ``last``. The colour grows by 1 with each ``band``
    voxels of height from the key ``base``, or, if ``by_belief``, with the log-odds up to ``greatest``.
    If ``seen_only``, faces towards unknown voxels are left out: no sensor has seen them.
    """

    occupied: float
    greatest: float
    first: int
    last: int
    base: int
    band: int
    colours: int
    by_belief: bool
    seen_only: bool
