"""Scheduling of computations."""
