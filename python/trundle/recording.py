"""Recordings: reading, construction and writing, with validation."""

from trundle._native import JointRecording, Recording, TrundleError, read

__all__ = ["JointRecording", "Recording", "TrundleError", "read"]
