"""Patched MJCF: the user's model with the refitted values and the missing effects of a diagnosis."""

from __future__ import annotations

from trundle.export.mjcf_patch.folder import write_mjcf_patch

__all__ = ["write_mjcf_patch"]
