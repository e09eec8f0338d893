"""SLAM of a session and its pose graph, see :mod:`mapper.slam`."""
