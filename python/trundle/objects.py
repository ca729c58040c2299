"""Object files: an object in each of its configurations, with the source of every value.

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
        Name of the object.
    radius : float or None
        Size for a planner, m: a final error below it counts as success (section V-B of the paper).
    bare : Model
        The body without any effect.
    models : dict of str to Model
        Models by configuration, in the order of the file; the first is the default.
    sources : dict of str to str or None
        Source of each value: ``radius``, ``body.mass``, ..., and ``configuration.NAME`` for all values of
        its effects.

    Examples
    --------
    >>> import trundle
    >>> table = trundle.objects.read("configs/objects/office_table.toml")
    >>> table.name, table.radius
    ('office table', 0.4)
    >>> table.models["locked"]
    <trundle.Model: 22 kg, viscous_wheel>
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
        An object file, such as those in ``configs/objects``.

    Returns
    -------
    Object

    Raises
    ------
    TrundleError
        If the file is invalid; the message names the file, the key and the value.

    Examples
    --------
    >>> import trundle
    >>> table = trundle.objects.read("configs/objects/office_table.toml")
    >>> sorted(table.models)
    ['locked', 'unlocked']
    """
    return Object(**_object(path))
