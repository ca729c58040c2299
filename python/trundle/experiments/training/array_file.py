"""Files of arrays with metadata, which NumPy reads without pickle."""

from __future__ import annotations

import json
import os
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray

from trundle._native import TrundleError
from trundle.atomic import atomic_file

__all__ = ["load", "save"]

ABOUT = "about"
T = TypeVar("T")


def save(
    path: str | os.PathLike[str], form: str, about: Mapping[str, Any], arrays: Mapping[str, NDArray[Any]]
) -> None:
    """Write arrays and their metadata atomically; the same content gives the same bytes."""
    content: dict[str, Any] = {**arrays, ABOUT: np.array(json.dumps({"format": form, **about}))}
    with atomic_file(Path(path)) as part, part.open("wb") as file:
        np.savez_compressed(file, **content)


def load(
    path: str | os.PathLike[str],
    form: str,
    what: str,
    build: Callable[[dict[str, Any], dict[str, NDArray[Any]]], T],
) -> T:
    """Read a file of `save`.

    Parameters
    ----------
    path : path-like
    form : str
        Its format.
    what : str
        What it should contain, for the message.
    build : callable
        Returns the result for the metadata and the arrays.

    Raises
    ------
    TrundleError
        If the file has another content.
    FileNotFoundError
        If there is no such file.
    """
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = dict(file)
        about = json.loads(str(arrays.pop(ABOUT)))
        if about.pop("format") != form:
            raise ValueError("another format")
        return build(about, arrays)
    except OSError:
        raise
    except Exception as error:  # damaged files raise various errors
        raise TrundleError(f"{path}: not a {what} of `trundle train` ({error})") from error
