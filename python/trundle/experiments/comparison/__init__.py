"""Agents on the same hidden worlds: played, kept, counted, and written down."""
