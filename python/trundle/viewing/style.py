"""Colours of the viewer, those of the report in the dark, and the order of names."""

from __future__ import annotations

__all__ = ["COLOURS", "Colour", "shade"]

Colour = tuple[int, int, int]

COLOURS: dict[str, Colour] = {
    "recorded": (0xC8, 0xD0, 0xD8),
    "before": (0xFF, 0x9A, 0x57),
    "after": (0x6F, 0xB8, 0xFF),
    "missing": (0xFF, 0x7E, 0xC0),
    "gripper": (0xE8, 0xD4, 0x6A),
    "goal": (0x3F, 0xD0, 0xA0),
    "obstacle": (0x8B, 0x95, 0xA0),
}
"""Colours by what they show."""


def shade(colour: Colour, step: int) -> Colour:
    """Return a darker variant of a colour, for the second and later curves of a source in one plot."""
    factor = 0.7**step
    red, green, blue = colour
    return round(red * factor), round(green * factor), round(blue * factor)
