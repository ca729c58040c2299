"""Guess of a map of CSV files: proposed keys with their basis, and questions for everything else."""

from trundle.importers.guess.guess import guess_from, guess_map, set_key
from trundle.importers.guess.map_text import map_text, write_map
from trundle.importers.guess.metadata import missing_metadata
from trundle.importers.guess.result import Assignment, MapGuess, Question
from trundle.importers.guess.table import Table, read_table

__all__ = [
    "Assignment",
    "MapGuess",
    "Question",
    "Table",
    "guess_from",
    "guess_map",
    "map_text",
    "missing_metadata",
    "read_table",
    "set_key",
    "write_map",
]
