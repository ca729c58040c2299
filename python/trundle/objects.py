"""Object files: what is pushed, in each of its configurations, and where every value comes from.

Examples
--------
>>> import trundle
>>> cart = trundle.objects.read("configs/objects/shopping_cart.toml")
>>> cart.name, sorted(cart.models)
('shopping cart', ['fixed rear wheels'])
"""

from __future__ import annotations

import os
from dataclasses import dataclass

from trundle._native import Model, _object

__all__ = ["Object", "read"]


@dataclass(frozen=True)
class Object:
    """An object.

    Attributes
    ----------
    name : str
        What it is called.
    radius : float or None
        Its size for a planner, m: a final error below it counts as success (section V-B of the paper).
    bare : Model
        The body alone, without any effect.
    models : dict of str to Model
        By configuration, in the file's order; the first is the usual one.
    sources : dict of str to str or None
        Where each value comes from: ``radius``, ``body.mass``, ..., and ``configuration.NAME`` for all values
        of its effects.
    """

    name: str
    radius: float | None
    bare: Model
    models: dict[str, Model]
    sources: dict[str, str | None]


def read(path: str | os.PathLike[str]) -> Object:
    """Read an object file.

    Parameters
    ----------
    path : path-like
        As those in ``configs/objects``.

    Returns
    -------
    Object

    Raises
    ------
    TrundleError
        If the file is not sound; the message names the file, the key and the value.
    """
    return Object(**_object(path))
