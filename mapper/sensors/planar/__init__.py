"""Planar scans cut out of point clouds and depth images."""
