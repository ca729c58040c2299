"""Streams: samples of one instrument at its own times."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from trundle._optional import require
from trundle.display import Card, Displayed

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

__all__ = ["Stream", "unit_of"]

Floats = NDArray[np.float64]


@dataclass(frozen=True, repr=False, eq=False)
class Stream(Mapping[str, Floats], Displayed):
    """Samples of one instrument: a mapping of column names to arrays without empty cells.

    Attributes
    ----------
    name : str
        ``object``, ``gripper``, ``wrench`` or ``reading``.
    t : array of shape (n,)
        Times of the samples, s.
    columns : dict of str to array of shape (n,)
        SI units; see `units`.
    description : str
        Frame of the columns.

    Examples
    --------
    >>> stream = recording["episode_00"].wrench
    >>> list(stream)
    ['force_x', 'force_y', 'torque_z']
    >>> bool(np.isnan(stream["force_x"]).any())
    False
    >>> stream.units["torque_z"]
    'N·m'
    """

    name: str
    t: Floats
    columns: Mapping[str, Floats]
    description: str

    def __getitem__(self, column: str) -> Floats:
        """Return a column, shape (n,)."""
        return self.columns[column]

    def __iter__(self) -> Iterator[str]:
        """Iterate over the names of the columns, without ``t``."""
        return iter(self.columns)

    def __len__(self) -> int:
        """Return the number of columns."""
        return len(self.columns)

    @property
    def array(self) -> Floats:
        """All columns side by side: shape (n, number of columns)."""
        return np.column_stack(list(self.columns.values()))

    @property
    def units(self) -> dict[str, str]:
        """SI unit of each column."""
        return {name: unit_of(name) for name in self.columns}

    @property
    def rate(self) -> float:
        """Sampling rate from the median interval, Hz; NaN for fewer than two samples."""
        return float(1.0 / np.median(np.diff(self.t))) if len(self.t) > 1 else float("nan")

    def frame(self) -> pd.DataFrame:
        """Return a pandas data frame with ``t`` and the columns.

        Examples
        --------
        >>> list(recording["episode_00"].object.frame().columns)
        ['t', 'object_x', 'object_y', 'object_theta']
        """
        pandas = require("pandas", "pandas", "data frames")
        table: pd.DataFrame = pandas.DataFrame({"t": self.t, **self.columns})
        return table

    def to_xarray(self, dim: str = "time") -> xr.Dataset:
        """Return an xarray dataset with one variable per column and its unit in ``attrs["units"]``.

        Parameters
        ----------
        dim : str
            Name of the dimension of the samples. Its coordinate is the time, s.

        Examples
        --------
        >>> data = recording["episode_00"].wrench.to_xarray()
        >>> data.force_x.dims, data.force_x.attrs["units"]
        (('time',), 'N')
        """
        xarray = require("xarray", "arviz", "xarray datasets")
        variables = {
            name: ((dim,), values, {"units": unit_of(name)}) for name, values in self.columns.items()
        }
        data: xr.Dataset = xarray.Dataset(
            variables, {dim: ((dim,), self.t, {"units": "s"})}, {"description": self.description}
        )
        return data

    def _card(self) -> Card:
        named = ", ".join(f"{name} [{unit}]" if unit else name for name, unit in self.units.items())
        return Card(f"trundle.Stream {self.name}: {len(self.t)} samples at {self.rate:.4g} Hz, {named}")


def unit_of(column: str) -> str:
    """Return the SI unit of a column of an episode."""
    if column == "t":
        return "s"
    kind, _, axis = column.rpartition("_")
    if kind in ("force", "torque"):
        return "N" if kind == "force" else "N·m"
    return {"theta": "rad", "x": "m", "y": "m", "z": "m"}.get(axis, "")
