"""Simulation of scenarios."""

from trundle._native import simulate

__all__ = ["simulate"]
