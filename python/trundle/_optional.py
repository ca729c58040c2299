"""Modules of optional dependencies."""

from __future__ import annotations

import importlib
from types import ModuleType

from trundle._native import TrundleError

__all__ = ["require"]


def require(module: str, extra: str, purpose: str) -> ModuleType:
    """Import and return an optional module.

    Parameters
    ----------
    module : str
        Name of the module.
    extra : str
        Extra of this package that installs it.
    purpose : str
        What needs it, in the plural, as the message begins with it: "plots".

    Returns
    -------
    module

    Raises
    ------
    TrundleError
        If the module is not installed; the message names the extra.
    """
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        package = module.partition(".")[0]
        if (error.name or "").partition(".")[0] != package:
            raise
        raise TrundleError(f"{purpose} need {package}: pip install 'trundle[{extra}]'") from error
