"""An octree with leaves that are too many voxels is refused when it is opened, not shown as an empty map."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from mapper.core.errors import LimitError
from mapper.core.limits import DEFAULT_LIMITS
from mapper.volume import Octree, OctreeFile
from server.sources.volume import VolumeModel


def opened(depth: int) -> VolumeModel:
    """Open a tree with eight occupied leaves of this depth."""
    masks = np.array([*[1] * (depth - 1), 255, *[0] * 8], dtype=np.uint8)
    tree = Octree(0.05, np.full(len(masks), 3.5, dtype=np.float32), masks)
    host: Any = SimpleNamespace(limits=lambda: DEFAULT_LIMITS)
    return VolumeModel(host, OctreeFile(".bt", b"", tree), log_id="log", title="tree.bt")


def test_a_tree_of_few_large_leaves_is_refused_with_the_number_of_its_voxels() -> None:
    assert opened(11).progress == (0, 1)
    with pytest.raises(LimitError, match=r"The leaves of the tree are 2\.81e\+14 voxels of 0\.05 m"):
        opened(1)
