"""Graph of poses and measured relative poses, as optimised by graph-based SLAM.

Source: Lu & Milios 1997, Globally consistent range scan alignment for environment mapping; Grisetti et al. 2010, A
tutorial on graph-based SLAM.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mapper.core.errors import ConfigError
from mapper.core.se2 import check_poses

ODOMETRY, LOOP = 0, 1  #: kinds of edges: between consecutive nodes, and between others
#: Residuals, in standard deviations, from which a loop is strained and from which it contradicts the other edges.
STRAINED, CONTRADICTS = 2.0, 5.0


@dataclass(frozen=True, slots=True)
class PoseGraph:
    """Poses and edges in arrays; an edge is a measurement ``Z ≈ Tᵢ⁻¹ ∘ Tⱼ`` between the nodes i and j.

    ``nodes`` (m,) int64 are scan numbers, ascending; ``poses`` (m, 3) are ``T_map_base``, metres and radians. ``i`` and
    ``j`` (e,) int64 are rows of ``nodes``; ``relative`` (e, 3) is Z; ``information`` (e, 3, 3) is its inverse
    covariance in the frame of Z, as in g2o; ``kind`` (e,) uint8 is :data:`ODOMETRY` or :data:`LOOP`. The robust kernel
    never reduces the weight of a ``locked`` (e,) loop. ``residual`` (e,) is √(eᵀ Ω e) at the poses, in standard
    deviations, and ``weight`` (e,) the robust kernel's factor, 0 to 1; both are set by the optimiser. Raises
    :class:`ConfigError` for inconsistent arrays.
    """

    nodes: NDArray[np.int64]
    poses: NDArray[np.float64]
    i: NDArray[np.int64]
    j: NDArray[np.int64]
    relative: NDArray[np.float64]
    information: NDArray[np.float64]
    kind: NDArray[np.uint8]
    locked: NDArray[np.bool_]
    residual: NDArray[np.float64]
    weight: NDArray[np.float64]

    def __post_init__(self) -> None:
        types = {"nodes": np.int64, "i": np.int64, "j": np.int64, "kind": np.uint8, "locked": np.bool_}
        for name in self.__dataclass_fields__:
            object.__setattr__(self, name, np.ascontiguousarray(getattr(self, name), dtype=types.get(name, np.float64)))
        m, e = len(self.nodes), len(self.i)
        check_poses(self.poses, (m, 3))
        check_poses(self.relative, (e, 3))
        shapes = {"j": (e,), "information": (e, 3, 3), "kind": (e,), "locked": (e,), "residual": (e,), "weight": (e,)}
        for name, shape in shapes.items():
            if getattr(self, name).shape != shape:
                raise ConfigError(
                    "graph.shape", f"The graph’s {name} must have shape {shape}, not {getattr(self, name).shape}."
                )
        ends = np.concatenate([self.i, self.j])
        if len(ends) and not (ends.min() >= 0 and ends.max() < m):
            raise ConfigError("graph.ends", f"An edge of the graph ends at a node that it lacks: it has {m}.")
        if (self.i == self.j).any():
            raise ConfigError(
                "graph.ends", f"Edge {int(np.argmax(self.i == self.j))} of the graph joins a node to itself."
            )
        if not np.isfinite(self.information).all():
            raise ConfigError("graph.information", "The information of an edge is not finite.")

    @property
    def n_loops(self) -> int:
        """Number of loop edges."""
        return int(np.count_nonzero(self.kind == LOOP))

    def with_loop(
        self, i: int, j: int, relative: ArrayLike, information: ArrayLike, *, locked: bool = False
    ) -> PoseGraph:
        """Return the graph with a loop appended as its last edge, from node row ``i`` to node row ``j``.

        ``relative`` (3,) is ``Tᵢ⁻¹ ∘ Tⱼ``, ``information`` (3, 3). Raises :class:`ConfigError`.
        """
        return replace(
            self,
            i=np.append(self.i, i),
            j=np.append(self.j, j),
            relative=np.concatenate([self.relative, np.reshape(np.asarray(relative, dtype=np.float64), (1, 3))]),
            information=np.concatenate(
                [self.information, np.reshape(np.asarray(information, dtype=np.float64), (1, 3, 3))]
            ),
            kind=np.append(self.kind, LOOP),
            locked=np.append(self.locked, locked),
            residual=np.append(self.residual, 0.0),
            weight=np.append(self.weight, 1.0),
        )

    def without_edge(self, edge: int) -> PoseGraph:
        """Return the graph without one of its loops. Raises :class:`ConfigError` for an edge that is not a loop."""
        self._check_loop(edge)
        others = np.arange(len(self.i)) != edge
        return replace(
            self,
            **{
                name: getattr(self, name)[others]
                for name in ("i", "j", "relative", "information", "kind", "locked", "residual", "weight")
            },
        )

    def with_lock(self, edge: int, *, locked: bool = True) -> PoseGraph:
        """Return the graph with a loop locked or unlocked. Raises :class:`ConfigError` for an edge that is not a
        loop.
        """
        self._check_loop(edge)
        changed = self.locked.copy()
        changed[edge] = locked
        return replace(self, locked=changed)

    def _check_loop(self, edge: int) -> None:
        if not 0 <= edge < len(self.i) or self.kind[edge] != LOOP:
            raise ConfigError("graph.edge", f"The graph has no loop with the number {edge}.")
