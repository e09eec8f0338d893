"""Truncated signed distances: surfaces fused from depth images and clouds."""
