"""Recordings: reading, construction and writing, with validation."""

from trundle._native import Recording, TrundleError, read

__all__ = ["Recording", "TrundleError", "read"]
