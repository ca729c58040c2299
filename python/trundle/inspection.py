"""Recordings looked into: figures, findings, tared and transformed wrenches, motion with its uncertainty."""

from trundle._native import check, inspect, prepare, smooth

__all__ = ["check", "inspect", "prepare", "smooth"]
