"""Figures of a run as inline SVG: the scene that moves, the wheel as it is found, numbers over time."""
