"""Recordings: read, made, written; each is checked before anybody computes with it."""

from trundle._native import Recording, TrundleError, read

__all__ = ["Recording", "TrundleError", "read"]
