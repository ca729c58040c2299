"""Colours of the viewer, those of the report in the dark, and the paths and colours of curves."""

from __future__ import annotations

from trundle.viewing.scene import Curve, Episode

__all__ = ["COLOURS", "Colour", "curve_path", "curve_styles"]

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


def curve_path(panel: str, curve: Curve) -> str:
    """Return the path of the entity of a curve."""
    return f"/plots/{panel}/{curve.name.replace(' ', '_')}"


def curve_styles(episode: Episode) -> dict[str, tuple[str, Colour]]:
    """Return name and colour of each curve of an episode by entity path."""
    styles: dict[str, tuple[str, Colour]] = {}
    for panel in episode.panels:
        count: dict[str, int] = {}
        for curve in panel.curves:
            step = count.get(curve.source, 0)
            count[curve.source] = step + 1
            styles[curve_path(panel.key, curve)] = (curve.name, shade(COLOURS[curve.source], step))
    return styles
