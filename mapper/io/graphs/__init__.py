"""Pose graphs in g2o's text format."""

from mapper.io.graphs.g2o import g2o_lines, read_g2o

__all__ = ["g2o_lines", "read_g2o"]
