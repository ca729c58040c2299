"""Comparison of agents on the same hidden worlds."""
