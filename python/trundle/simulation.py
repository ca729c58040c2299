"""Scenarios and the recordings that are simulated from them."""

from trundle._native import simulate

__all__ = ["simulate"]
