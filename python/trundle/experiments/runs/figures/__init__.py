"""Figures of a run as inline SVG: the animated scene, the estimated wheel, and numbers over time."""
