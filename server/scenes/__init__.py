"""The 3D view: a viser server for each session that is viewed in 3D, on a Unix socket behind a proxy."""

from server.scenes.scenes import Scenes

__all__ = ["Scenes"]
