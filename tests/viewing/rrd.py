"""Contents of .rrd files, read with rerun-sdk."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

chunk = pytest.importorskip("rerun.chunk")

__all__ = ["Rrd"]


class Rrd:
    """The rows of an .rrd file by entity and component."""

    def __init__(self, path: Path) -> None:
        self._rows: dict[str, list[tuple[float | None, int | None, str, Any]]] = {}
        for each in chunk.RrdReader(path).stream().to_chunks():
            columns = each.to_record_batch().to_pydict()
            count = each.num_rows
            times = [None if t is None else t.total_seconds() for t in columns.get("time", [None] * count)]
            episodes = columns.get("episode", [None] * count)
            rows = self._rows.setdefault(each.entity_path, [])
            for component, cells in columns.items():
                if ":" in component:
                    rows += [
                        (time, episode, component, cell)
                        for time, episode, cell in zip(times, episodes, cells, strict=True)
                        if cell is not None
                    ]

    @property
    def entities(self) -> set[str]:
        return set(self._rows)

    def rows(self, entity: str, component: str) -> list[tuple[float | None, int | None, Any]]:
        """Time, episode and value of each row, in the order of time."""
        found = [
            (time, episode, cell)
            for time, episode, name, cell in self._rows[entity]
            if name.split(":")[1] == component
        ]
        return sorted(found, key=lambda row: (row[0] is not None, row[0]))

    def array(self, entity: str, component: str, episode: int | None = None) -> tuple[Any, Any]:
        """Times (n,) and values of the rows with one instance each, of one or of all episodes."""
        rows = [row for row in self.rows(entity, component) if episode in (None, row[1])]
        return np.array([row[0] for row in rows]), np.array([row[2][0] for row in rows])

    def only(self, entity: str, component: str) -> Any:
        """Return the value of the only row."""
        ((_, _, value),) = self.rows(entity, component)
        return value

    def contents(self) -> dict[str, list[str]]:
        """Return all rows as text, without identifiers."""
        return {entity: sorted(map(repr, rows)) for entity, rows in self._rows.items()}
