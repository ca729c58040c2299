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
import sys
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import tomli_w

from trundle._native import Model, _object
from trundle.atomic import write_text
from trundle.display import Card, Displayed
from trundle.display.formatting import join_names

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["Object", "read", "task_options"]


def __dir__() -> list[str]:
    return __all__


_FORMAT = "trundle-object/1"


@dataclass(frozen=True, repr=False)
class Object(Displayed):
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
    >>> table.models["locked"].effects
    ['viscous_wheel']
    """

    name: str
    radius: float | None
    bare: Model
    models: dict[str, Model]
    sources: dict[str, str | None]

    def _card(self) -> Card:
        radius = "not stated" if self.radius is None else f"{self.radius:.3g} m"
        facts = [("configurations", join_names(list(self.models))), ("radius", radius)]
        return Card(f"trundle.objects.Object {self.name!r}", facts)


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


def task_options(model: Model | str | os.PathLike[str], path: str | os.PathLike[str]) -> dict[str, Any]:
    """Write the body of a model as an object file, and return the options of a task with this model.

    Parameters
    ----------
    model : Model or path-like
        A model with a footprint and a value for every parameter, such as ``model.toml`` of a diagnosis.
    path : path-like
        The object file, which is written atomically.

    Returns
    -------
    dict
        ``object``, ``hidden`` and ``effects``: keyword arguments of `gymnasium.make` with which an
        environment of `trundle.envs` simulates exactly this model.

    Raises
    ------
    TrundleError
        If the model file cannot be read.

    Examples
    --------
    >>> import gymnasium, trundle
    >>> options = trundle.objects.task_options("model.toml", "object.toml")  # doctest: +SKIP
    >>> env = gymnasium.make("trundle/PushPose-v0", **options)  # doctest: +SKIP
    """
    content = tomllib.loads((model if isinstance(model, Model) else Model.read(model)).to_toml())
    name = Path(path).stem
    write_text(Path(path), tomli_w.dumps({"format": _FORMAT, "name": name, "body": content["body"]}))
    return {"object": os.fspath(path), "hidden": "none", "effects": content.get("effect", [])}
