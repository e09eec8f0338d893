"""Hash table of blocks of 8³ voxels, from the code of a block to the slot of its voxels.

The code of a block has 13 bits for each axis: x, y and z of its first voxel's key, divided by 8. Source: Nießner,
Zollhöfer, Izadi & Stamminger, Real-time 3D reconstruction at scale using voxel hashing, 2013, for voxels in hashed
blocks of 8³; here with linear probing.
"""

from __future__ import annotations

from mapper.core.array_types import Int32Array, Int64Array
from mapper.core.jit import jit
from mapper.volume.kernels.types import BlockTable


@jit
def block_code(x: int, y: int, z: int) -> int:
    """Return the code of the block that contains the voxel of key (x, y, z)."""
    return (z >> 3) << 26 | (y >> 3) << 13 | (x >> 3)


@jit
def _home_of(code: int, n: int) -> int:
    """Return the first slot to probe for a code in a table of length ``n``, a power of two.

    Source: Teschner, Heidelberger, Müller, Pomerantes & Gross, Optimized spatial hashing for collision detection of
    deformable objects, 2003.
    """
    return ((code & 8191) * 73856093 ^ (code >> 13 & 8191) * 19349663 ^ (code >> 26) * 83492791) & (n - 1)


@jit
def slot_of(table: BlockTable, code: int) -> int:
    """Return the slot of a block, −1 if it is not in the table."""
    n = table.codes.shape[0]
    at = _home_of(code, n)
    while table.codes[at] >= 0:
        if table.codes[at] == code:
            return int(table.slots[at])
        at = (at + 1) & (n - 1)
    return -1


@jit
def find_slots(table: BlockTable, codes: Int64Array, out: Int32Array) -> None:
    """Write the slots (n,) of blocks, −1 for those not in the table."""
    for i in range(codes.shape[0]):
        out[i] = slot_of(table, codes[i])


@jit
def add_blocks(table: BlockTable, codes: Int64Array, first_slot: int, out: Int32Array) -> int:
    """Write the slots (n,) of blocks, and assign slots from ``first_slot`` on to new ones; return the number of new
    ones.

    The table must be long enough.
    """
    n = table.codes.shape[0]
    slot = first_slot
    for i in range(codes.shape[0]):
        code = codes[i]
        at = _home_of(code, n)
        while table.codes[at] >= 0 and table.codes[at] != code:
            at = (at + 1) & (n - 1)
        if table.codes[at] < 0:
            table.codes[at] = code
            table.slots[at] = slot
            slot += 1
        out[i] = table.slots[at]
    return slot - first_slot
