"""Commands on point clouds."""
