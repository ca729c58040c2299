"""Colours of all figures: those of the light theme of the report's style sheet.

The four colours of curves (recorded, before, after, mark) differ in lightness as well as in hue, so that they
remain distinct with a colour vision deficiency and in greyscale.
"""

from __future__ import annotations

__all__ = [
    "AFTER",
    "BEFORE",
    "GOAL",
    "INK",
    "LINE",
    "MARK",
    "MUTED",
    "PAPER",
    "RECORDED",
    "SOFT",
    "WINDOW",
]

PAPER = "#fff"
INK = "#1b1f24"
"""Text, outlines and true values."""
MUTED = "#5a6470"
"""Axes, ticks and secondary text."""
LINE = "#d5dae0"
"""Grids and frames."""
SOFT = "#f4f6f8"
"""Filled areas."""
RECORDED = "#8b95a0"
"""Recorded motion, and bands of noise."""
BEFORE = "#c04a00"
"""Simulation without the missing effects."""
AFTER = "#0059a8"
"""Simulation with the missing effects, a fitted model, and estimates."""
MARK = "#b0186f"
"""Missing effects and where they act."""
WINDOW = "#f2d98c"
"""Windows of time that exceed the noise."""
GOAL = "#00785a"
"""Goal of a task."""
