"""Figures as inline SVG, 360 user units wide."""
