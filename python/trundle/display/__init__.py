"""Representations of objects: a few lines of text for a terminal, a compact table for a notebook."""

from trundle.display.card import Card, Displayed, Table

__all__ = ["Card", "Displayed", "Table"]
