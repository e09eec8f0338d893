"""Compiled updates: arrays in, ``out`` arrays written; no classes, no I/O, never raise."""
