"""Families that are hidden in recordings of furniture."""

from __future__ import annotations

from trundle.experiments.blind import families

__all__ = ["FAMILIES", "OUT_OF_CATALOGUE"]

UNKNOWN_NAMES = """
magnet warming_wheel shaking rattling_load hysteretic_spring sticky_ground magnetic_line rate_and_state
fading_friction sail resonant_sensor stretched_picture
"""
"""Families outside the catalogue, in the order on which the drawn cases depend."""
OUT_OF_CATALOGUE = families.selected(families.UNKNOWN, UNKNOWN_NAMES.split())
FAMILIES = {**families.CATALOGUE, **OUT_OF_CATALOGUE}
