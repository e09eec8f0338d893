"""The 3D view: one loopback-only viser server for each session that asks, behind a proxy."""

from server.scenes.scenes import Scenes

__all__ = ["Scenes"]
