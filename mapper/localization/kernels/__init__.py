"""Compiled functions of Monte Carlo localization: arrays and numbers in, ``out`` written."""
