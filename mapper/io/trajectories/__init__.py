"""Readers of trajectories and of relations between places, which accompany logs."""

from mapper.io.trajectories.joining import poses_at_all_scans, with_trajectory
from mapper.io.trajectories.relations import read_relations
from mapper.io.trajectories.tum import read_tum

__all__ = ["poses_at_all_scans", "read_relations", "read_tum", "with_trajectory"]
