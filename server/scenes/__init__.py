"""The 3D view: one viser server for each session that asks, on a Unix socket behind a proxy."""

from server.scenes.scenes import Scenes

__all__ = ["Scenes"]
