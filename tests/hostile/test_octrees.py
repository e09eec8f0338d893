"""Octree files that are wrong or malicious: each has its own sentence."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from mapper.core.errors import LimitError, MapperError, ReadError
from mapper.core.limits import DEFAULT_LIMITS
from mapper.volume import OccupancyVolume, Octree, VolumeConfig, octree_file, read_octree
from mapper.volume.octree.files import OctreeFile, octree_of_bytes
from tests.hostile.damage import ALL, ROUNDS, check_sentence, flipped

CONFIG = VolumeConfig(resolution=0.1)
HEAD = b"# Octomap OcTree%s file\n#\nid OcTree\nsize %d\nres %s\ndata\n"


def files() -> dict[str, bytes]:
    volume = OccupancyVolume(CONFIG)
    volume.insert_scan(np.random.default_rng(1).uniform(0.0, 1.0, (40, 3)), [0.5, 0.5, 0.5])
    tree = Octree.of(volume)
    return {kind: octree_file(tree, kind, CONFIG).bytes() for kind in (".bt", ".ot")}


def bt(data: bytes, size: int = 1, resolution: bytes = b"0.1") -> bytes:
    return HEAD % (b" binary", size, resolution) + data


def ot(data: bytes, size: int = 1, resolution: bytes = b"0.1") -> bytes:
    return HEAD % (b"", size, resolution) + data


ONE = b"\0\0\0\x3f"  # log-odds 0.5

BAD = {
    "no octree": (b"P5\n4 3\n", "does not begin as an octree"),
    "no data": (b"# Octomap OcTree file\nid OcTree\n", "has no line 'data'"),
    "another tree": (
        ot(ONE + b"\0").replace(b"id OcTree", b"id CountingOcTree"),
        "'CountingOcTree'; OcTree, OcTreeStamped, ColorOcTree are read",
    ),
    "no tree": (bt(b"\0\0").replace(b"id OcTree\n", b""), "a tree of the kind 'unknown'"),
    "no size": (ot(ONE + b"\0").replace(b"size 1", b"size many"), "lines 'res' and 'size' with numbers"),
    "no resolution": (ot(ONE + b"\0", resolution=b"-1"), "resolution in x must be a positive number"),
    "resolution nan": (ot(ONE + b"\0", resolution=b"nan"), "resolution in x must be a positive number"),
    "another size": (ot(ONE + b"\0", size=7), "says that it has 7 nodes, but its tree has 1"),
    "ends early": (ot(ONE + b"\x01" + ONE[:3], size=2), "ends at byte 62, before its tree does"),
    "ends early, bt": (bt(b"\x03\0", size=2), "ends at byte 63, before its tree does"),
    "too deep": (ot((ONE + b"\x01") * 17 + ONE + b"\0", size=18), "deeper than 16 levels"),
    "too deep, bt": (bt(b"\x03\0" * 16 + b"\x01\0", size=18), "deeper than 16 levels"),
    "no children": (bt(b"\x03\0\0\0", size=2), "should have children and has none"),
    "log-odds nan": (ot(b"\0\0\xc0\x7f\0"), "Node 0 of x, at byte 54, has log-odds that are not finite"),
}


@pytest.mark.parametrize(("content", "said"), BAD.values(), ids=BAD)
def test_bad_octrees_are_refused(content: bytes, said: str, tmp_path: Path) -> None:
    path = tmp_path / "x"
    path.write_bytes(content)
    with pytest.raises(ReadError) as caught:
        read_octree(path)
    check_sentence(caught.value, path, "octree")
    assert said in caught.value.message


def test_an_empty_octree_is_read_and_written() -> None:
    for content in (bt(b"", size=0), ot(b"", size=0)):
        read = octree_of_bytes(content, "x")
        assert read.tree.n_nodes == 0
        assert read.bytes() == content
        assert read.tree.volume(CONFIG).n_known == 0


def test_a_small_file_may_not_take_all_memory(tmp_path: Path) -> None:
    """One leaf below the root is 32,768³ voxels."""
    read = octree_of_bytes(bt(b"\x01\0", size=2), "x")
    with pytest.raises(LimitError, match=r"leaves of the tree are 3\.52e\+13 voxels of 0\.1 m"):
        read.tree.volume(CONFIG)
    path = tmp_path / "large.bt"
    path.write_bytes(files()[".bt"])
    with pytest.raises(LimitError, match=r"large\.bt has .* bytes, more than 100"):
        read_octree(path, replace(DEFAULT_LIMITS, max_unpacked_bytes=100))


def usable(content: bytes) -> None:
    """Either one of our errors, or a tree that is written as it was read and is a map."""
    limits = replace(DEFAULT_LIMITS, max_blocks=1 << 10)
    try:
        read: OctreeFile = octree_of_bytes(content, "x")
        assert read.bytes() == content
        read.tree.volume(CONFIG, limits)
    except MapperError as error:
        check_sentence(error, Path("/nowhere/x"), "octree", "volume")


@pytest.mark.sampled
@pytest.mark.parametrize("kind", [".bt", ".ot"])
def test_flips(kind: str) -> None:
    content, rng = files()[kind], np.random.default_rng(17)
    for _ in range(ROUNDS):
        usable(flipped(rng, content))


@pytest.mark.sampled
@pytest.mark.parametrize("kind", [".bt", ".ot"])
def test_every_prefix_is_refused(kind: str) -> None:
    content = files()[kind]
    for end in range(0, len(content), 1 if ALL else 37):
        with pytest.raises(MapperError):
            octree_of_bytes(content[:end], "x")
