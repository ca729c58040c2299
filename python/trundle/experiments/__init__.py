"""Experiments on one shared runner."""
