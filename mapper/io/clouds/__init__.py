"""Point clouds: those of recordings, as streams that are read when they are iterated."""

from mapper.io.clouds.recorded import open_clouds

__all__ = ["open_clouds"]
