"""OctoMap's octree files: ``.bt``, with free and occupied leaves, and ``.ot``, with their log-odds.

A file that is read and not changed is written byte for byte. Source: octomap's AbstractOcTree::read and
AbstractOccupancyOcTree::readBinary, which reads the data of trees of all kinds, and AbstractOcTree::readHeader.
"""

from __future__ import annotations

import math
import os
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from mapper.core.array_types import Float64Array, UInt8Array
from mapper.core.atomic_file import atomic_write
from mapper.core.errors import ConfigError, LimitError, ReadError
from mapper.core.limits import DEFAULT_LIMITS, Limits
from mapper.volume.kernels.octree import ENDS_EARLY, NO_CHILDREN, read_bt, read_ot, write_bt
from mapper.volume.occupancy.parameters import VolumeConfig
from mapper.volume.octree.octree import Octree

_FIRST_LINES = {".bt": b"# Octomap OcTree binary file", ".ot": b"# Octomap OcTree file"}
_HEADER = (
    "{}\n# (feel free to add / change comments, but leave the first line as it is!)\n#\n{}"
    "id OcTree\nsize {}\nres {}\ndata\n"
)
_OFFSET = re.compile(rb"^# offset((?: -?[0-9][0-9.e+-]{0,30}){3})$", re.MULTILINE)
_MOST_HEADER = 1 << 16  # bytes
#: Bytes per node of a .ot file: log-odds, three more for colour, children. The stamps of OcTreeStamped are not written.
_TREES = {"OcTree": 5, "OcTreeStamped": 5, "ColorOcTree": 8}
_OLD_IDS = {"1": "OcTree"}  #: still accepted by OctoMap


@dataclass(frozen=True, slots=True)
class OctreeFile:
    """An octree file: its kind, ``.bt`` or ``.ot``, its ``header`` and the tree.

    ``notes`` are sentences on differences between the file and what was read.
    """

    kind: str
    header: bytes
    tree: Octree
    notes: tuple[str, ...] = ()

    @property
    def offset(self) -> Float64Array:
        """Offset (3,), metres, between the tree and the original coordinates: a comment in our own files."""
        match = _OFFSET.search(self.header)
        try:
            return np.zeros(3) if match is None else np.array([float(word) for word in match[1].split()])
        except ValueError:
            return np.zeros(3)

    def bytes(self, config: VolumeConfig | None = None) -> bytes:
        """Return the bytes of the file. ``config`` has the occupancy threshold of the leaves."""
        return self.header + _data(self.kind, self.tree, VolumeConfig() if config is None else config)


def is_octree(start: bytes) -> bool:
    """Return whether a file that starts with these bytes is an OctoMap octree."""
    return any(start.startswith(line) for line in _FIRST_LINES.values())


def octree_file(tree: Octree, kind: str, config: VolumeConfig, offset: Float64Array | None = None) -> OctreeFile:
    """Return a tree as a new file; for ``.bt`` it is first reduced to free and occupied leaves.

    ``offset`` is that of :attr:`OctreeFile.offset`, a comment of the header. Raises :class:`ConfigError` for a kind
    that is neither ``.bt`` nor ``.ot``.
    """
    if kind not in _FIRST_LINES:
        raise ConfigError("octree.kind", f"An octree is written as .bt or .ot, not {kind!r}.")
    tree = tree.max_likelihood(config) if kind == ".bt" else tree
    short = f"{tree.resolution:g}"  # OctoMap's notation, unless it loses digits
    resolution = short if float(short) == tree.resolution else repr(tree.resolution)
    moved = "" if offset is None or not offset.any() else f"# offset {' '.join(map(repr, offset.tolist()))}\n"
    header = _HEADER.format(_FIRST_LINES[kind].decode(), moved, tree.n_nodes, resolution)
    return OctreeFile(kind, header.encode(), tree)


def read_octree(path: str | os.PathLike[str], limits: Limits = DEFAULT_LIMITS) -> OctreeFile:
    """Read a ``.bt`` or ``.ot`` file, which is recognised by its first line.

    The leaves of a ``.bt`` get the minimum and maximum log-odds of OctoMap's defaults. Raises :class:`ReadError` for a
    file that is neither or is damaged, and :class:`LimitError` for one that exceeds the limits.
    """
    path = Path(path)
    size = path.stat().st_size
    if size > limits.max_unpacked_bytes:
        raise LimitError(
            "octree.too_large", f"{path.name} has {size:,} bytes, more than {limits.max_unpacked_bytes:,}."
        )
    return octree_of_bytes(path.read_bytes(), path.name)


def octree_of_bytes(content: bytes, name: str) -> OctreeFile:
    """Return the octree in the bytes of a file; ``name`` is used in errors. Raises the errors of
    :func:`read_octree`.
    """
    kind = next((kind for kind, line in _FIRST_LINES.items() if content.startswith(line)), None)
    if kind is None:
        raise ReadError("octree.format", f"{name} does not begin as an octree of OctoMap, .bt or .ot, does.")
    resolution, size, begin, tree_kind = _read_header(content, name)
    if not tree_kind or (kind == ".ot" and tree_kind not in _TREES):
        raise ReadError(
            "octree.id",
            f"{name} holds a tree of the kind {tree_kind or 'unknown'!r:.40}; {', '.join(_TREES)} are read.",
        )
    data = np.frombuffer(content, dtype=np.uint8)[begin:]
    if size == 0 and not len(data):
        return OctreeFile(kind, content, Octree(resolution, np.empty(0, np.float32), np.empty(0, np.uint8)))
    if kind == ".bt":
        tree, read = _read_bt(data, resolution, name, begin)
    else:
        tree, read = _read_ot(data, resolution, name, begin, _TREES[tree_kind])
    if tree.n_nodes != size:
        raise ReadError("octree.size", f"{name} says that it has {size} nodes, but its tree has {tree.n_nodes}.")
    notes = []
    has_colours = kind == ".ot" and _TREES[tree_kind] > _TREES["OcTree"]
    if has_colours:
        notes.append(f"{name} is a {tree_kind}: its occupancy is read, its colours are not.")
    if read < len(data):
        notes.append(f"{name} has {len(data) - read} bytes after its tree, which say nothing of it.")
    header = _as_octree(content[:begin]) if has_colours else content[:begin]
    return OctreeFile(kind, header, tree, tuple(notes))


def write_octree(file: OctreeFile, path: str | os.PathLike[str], config: VolumeConfig | None = None) -> None:
    """Write an octree, replacing an existing file only after everything is written."""
    with atomic_write(Path(path)) as out:
        out.write(file.bytes(config))


def _as_octree(header: bytes) -> bytes:
    """Return the header of a tree without colours."""
    return re.sub(rb"(?m)^id .*$", b"id OcTree", header)


def _read_header(content: bytes, name: str) -> tuple[float, int, int, str]:
    """Return the resolution, the number of nodes, the start of the data, and the kind of the tree."""
    header: dict[str, str] = {}
    at = 0
    while True:
        end = content.find(b"\n", at, _MOST_HEADER)
        if end < 0:
            raise ReadError("octree.header", f"The header of {name} has no line 'data'.")
        words = content[at:end].decode("ascii", "replace").split()
        at = end + 1
        while words[:1] and words[0] in ("id", "size", "res"):
            header[words[0]], words = "".join(words[1:2]), words[2:]
        if words[:1] == ["data"]:
            break
    try:
        resolution, size = float(header["res"]), int(header["size"])
    except (KeyError, ValueError):
        raise ReadError(
            "octree.header", f"The header of {name} must have lines 'res' and 'size' with numbers."
        ) from None
    if not (math.isfinite(resolution) and resolution > 0.0):
        raise ReadError("octree.resolution", f"The resolution in {name} must be a positive number, not {resolution}.")
    kind = header.get("id", "")
    return resolution, size, at, _OLD_IDS.get(kind, kind)


def _read_ot(data: UInt8Array, resolution: float, name: str, begin: int, width: int) -> tuple[Octree, int]:
    """Return the tree of nodes of ``width`` bytes, and its total number of bytes."""
    size = len(data)
    if width != 5:  # the colour is between log-odds and children
        rows = data[: size // width * width].reshape(-1, width)
        data = np.ascontiguousarray(np.concatenate([rows[:, :4], rows[:, -1:]], axis=1)).reshape(-1)
    masks = np.empty(len(data) // 5 + 1, dtype=np.uint8)
    n = read_ot(data, masks)
    _check(n, width * max(n, 0), size, name, begin)
    values = data[: 5 * n].reshape(n, 5)[:, :4].copy().view("<f4")[:, 0].astype(np.float32)
    if not np.isfinite(values).all():
        at = int(np.argmin(np.isfinite(values)))
        raise ReadError(
            "octree.value", f"Node {at} of {name}, at byte {begin + width * at}, has log-odds that are not finite."
        )
    return Octree(resolution, values, masks[:n]), width * n


def _read_bt(data: UInt8Array, resolution: float, name: str, begin: int) -> tuple[Octree, int]:
    room = 1 + 8 * (len(data) // 2)
    values, masks = np.empty(room, dtype=np.float32), np.empty(room, dtype=np.uint8)
    config = VolumeConfig()
    n, read = read_bt(data, config.log_odds_min, config.log_odds_max, values, masks)
    _check(n, read, len(data), name, begin)
    return Octree(resolution, values[:n], masks[:n]).completed(), read


def _check(n: int, read: int, size: int, name: str, begin: int) -> None:
    if n == ENDS_EARLY:
        raise ReadError("octree.ends_early", f"{name} ends at byte {begin + size}, before its tree does.")
    if n == NO_CHILDREN:
        raise ReadError(
            "octree.no_children", f"The node at byte {begin + read} of {name} should have children and has none."
        )
    if n < 0:
        raise ReadError("octree.too_deep", f"The tree of {name} is deeper than 16 levels.")


def _data(kind: str, tree: Octree, config: VolumeConfig) -> bytes:
    n = tree.n_nodes
    if kind == ".ot":
        nodes = np.empty((n, 5), dtype=np.uint8)
        nodes[:, :4] = tree.values.astype("<f4")[:, None].view(np.uint8)
        nodes[:, 4] = tree.masks
        return nodes.tobytes()
    inner = int((tree.masks[1:] != 0).sum()) + (n > 0)
    out = np.empty(2 * inner, dtype=np.uint8)
    write_bt(tree.values, tree.masks, config.log_odds_occupied, out)
    return out.tobytes()
