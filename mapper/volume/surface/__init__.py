"""Truncated signed distance fields: surfaces fused from depth images and clouds."""
