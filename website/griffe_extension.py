"""Docstrings of the compiled module for the API reference: its stub file contains signatures only."""

from __future__ import annotations

import importlib
import inspect
from typing import Any

import griffe

__all__ = ["CompiledDocstrings"]

COMPILED = "trundle._native"
OPTIONS: griffe.NumpyOptions = {"warn_unknown_params": False}
"""Settings that are passed on as keywords are parameters too."""


class CompiledDocstrings(griffe.Extension):
    """Adds the docstrings of compiled objects, and the parameters of their classes."""

    def on_class_members(self, *, cls: griffe.Class, **_: Any) -> None:
        """Take the parameters of a compiled class from `__new__`, which its docstring describes."""
        if cls.path.startswith(f"{COMPILED}.") and "__new__" in cls.members:
            constructor = cls.members.pop("__new__")
            constructor.name = "__init__"
            cls.members["__init__"] = constructor

    def on_object(self, *, obj: griffe.Object, **_: Any) -> None:
        """Add the docstring of an object of the compiled module."""
        if not obj.path.startswith(f"{COMPILED}.") or obj.docstring is not None:
            return
        found: Any = importlib.import_module(COMPILED)
        for name in obj.path.removeprefix(f"{COMPILED}.").split("."):
            found = getattr(found, name, None)
        text = inspect.getdoc(found)
        if text and obj.name != "__new__" and not isinstance(found, (int, float, str, list)):
            obj.docstring = griffe.Docstring(text, parent=obj, parser="numpy", parser_options=OPTIONS)
