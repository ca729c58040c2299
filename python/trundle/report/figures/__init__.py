"""Figures as inline SVG, each 360 units wide, one idea a file."""
