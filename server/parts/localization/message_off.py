"""Shared by the localization of a simulation and of a log: columns of the particles, and the empty message."""

from __future__ import annotations

from typing import Any

COLUMNS = ("x", "y", "yaw", "value")  #: of the layer of the particles

OFF: dict[str, Any] = {
    "type": "localization", "is_on": False, "map": "plan", "values": {}, "pose": None, "at": None, "covariance": None,
    "is_converged": False, "is_sure": False, "share": 0.0, "fit": 0.0,
    "entropy": 0.0, "n_particles": 0, "n_updates": 0, "error_m": None, "error_rad": None,
}  # fmt: skip
"""The message ``localization`` of a session without a filter."""
