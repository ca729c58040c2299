"""Import of optional packages, each of which an extra of trundle installs."""

from __future__ import annotations

import importlib
from typing import Any

from trundle._native import TrundleError

__all__ = ["require"]


def require(module: str, extra: str, purpose: str) -> Any:
    """Import a module of an optional package.

    Parameters
    ----------
    module : str
        Name of the module, such as "matplotlib.figure".
    extra : str
        The extra of trundle that installs the package.
    purpose : str
        What needs the package, as a plural noun: the subject of the error message.

    Returns
    -------
    module

    Raises
    ------
    TrundleError
        If the package is not installed. An error in an installed package propagates.

    Examples
    --------
    >>> from trundle._optional import require
    >>> require("no_such_package.io", "plots", "plots")
    Traceback (most recent call last):
    trundle.TrundleError: plots need no_such_package: pip install 'trundle[plots]'
    """
    package = module.partition(".")[0]
    try:
        return importlib.import_module(module)
    except ModuleNotFoundError as error:
        if (error.name or "").partition(".")[0] != package:
            raise
        raise TrundleError(f"{purpose} need {package}: pip install 'trundle[{extra}]'") from error
