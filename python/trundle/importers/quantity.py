"""Vectors of a file (CSV columns, MATLAB variables) in SI units."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import numpy as np

from trundle.importers.config import MapError
from trundle.importers.layout import Floats, SourceError

__all__ = ["Quantity", "Vectors", "numbers"]


class Vectors(Protocol):
    """A file of named vectors."""

    path: Path

    def vector(self, name: str, index: int | None = None) -> Floats:
        """Return a vector, NaN where a cell is empty; `index` selects a column of a matrix, from 1."""


@dataclass(frozen=True)
class Quantity:
    """Source of one column of the recording.

    Attributes
    ----------
    name : str
        Column or variable of the file.
    product : list of str
        Several names, instead of `name`, that are multiplied. A scalar multiplies all samples.
    sum : list of str or Quantity
        Several quantities, instead of `name`, that are added, such as seconds and nanoseconds.
    index : int
        Column of a matrix variable, from 1.
    unit : str
        "mm", "deg", "ms", …; by default SI.
    scale : float
        A factor, such as -1 for an axis in the opposite direction.
    """

    name: str | None = None
    product: list[str] | None = None
    sum: list[str | Quantity] | None = None
    index: int | None = None
    unit: str | None = None
    scale: float = 1.0

    def size(self, units: Mapping[str, float], where: str) -> float:
        """Return the factor from values of the file to SI units; `where` is the key of the map."""
        unit = next(iter(units)) if self.unit is None else self.unit
        if unit not in units:
            listing = ", ".join(map(repr, units))
            raise MapError(f"`{where}.unit` = {unit!r}: unknown unit; use one of {listing}")
        return units[unit] * self.scale


def numbers(file: Vectors, what: str | Quantity, units: Mapping[str, float], where: str) -> Floats:
    """Return the values of a quantity in SI units.

    Parameters
    ----------
    file : Vectors
        The file.
    what : str or Quantity
        Name of a column or variable, or more.
    units : mapping
        Size of each allowed unit in SI units; the first one is the default.
    where : str
        Key of the map, for messages.
    """
    quantity = Quantity(name=what) if isinstance(what, str) else what
    if [quantity.name, quantity.product, quantity.sum].count(None) != 2:
        raise MapError(f"`{where}`: give one of `name`, `product` and `sum`")
    size = quantity.size(units, where)
    if quantity.sum is not None:
        terms = [numbers(file, term, units, f"{where}.sum") for term in quantity.sum]
        return np.asarray(np.sum(terms, axis=0) * size)
    names = quantity.product or [str(quantity.name)]
    factors = [file.vector(name, quantity.index) for name in names]
    longest = max(len(factor) for factor in factors)
    for name, factor in zip(names, factors, strict=True):
        if len(factor) not in (1, longest):
            raise SourceError(
                file.path,
                f"`{name}` has {len(factor)} samples, but other factors of `{where}` have {longest}",
            )
    return np.asarray(np.prod(np.broadcast_arrays(*factors), axis=0) * size)
