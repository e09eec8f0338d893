"""Planar scans extracted from point clouds and depth images."""
