"""Simulation of scenarios."""

from trundle._native import demo, simulate

__all__ = ["demo", "simulate"]
