"""Inspection of recordings: statistics, checks, tared and transformed wrenches, smoothed motion."""

from trundle._native import check, inspect, prepare, smooth

__all__ = ["check", "inspect", "prepare", "smooth"]
