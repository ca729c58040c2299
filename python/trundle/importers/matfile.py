"""The variables of a MATLAB file, whatever its version."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import numpy as np
import scipy.io

from trundle.importers.layout import Floats, SourceError

__all__ = ["MatFile"]


class MatFile:
    """Numeric variables of a `.mat` file, flattened.

    Parameters
    ----------
    path : Path
        Version 4 to 7 by SciPy; 7.3 (an HDF5 file) if `h5py` is installed.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._variables = _load(path)

    def vector(self, name: str) -> Floats:
        """Return one numeric variable as a vector; a scalar has length 1."""
        if name not in self._variables:
            raise SourceError(self.path, f"no variable `{name}`; the file holds {self._listing()}")
        try:
            return np.asarray(self._variables[name], dtype=np.float64).ravel(order="F")
        except (TypeError, ValueError) as error:
            raise SourceError(
                self.path,
                f"variable `{name}` is no array of numbers; export its field as a variable of its own",
            ) from error

    def __contains__(self, name: str) -> bool:
        return name in self._variables

    def _listing(self) -> str:
        return ", ".join(f"`{name}` {np.shape(value)}" for name, value in sorted(self._variables.items()))


def _load(path: Path) -> dict[str, Any]:
    if not path.is_file():
        raise SourceError(path, "no such file")
    try:
        variables = scipy.io.loadmat(str(path))
    except NotImplementedError:
        return _load_hdf5(path)
    except (ValueError, OSError, TypeError, scipy.io.matlab.MatReadError) as error:
        raise SourceError(path, f"not a MATLAB file that can be read ({error})") from error
    return {name: value for name, value in variables.items() if not name.startswith("__")}


def _load_hdf5(path: Path) -> dict[str, Any]:
    try:
        h5py: Any = importlib.import_module("h5py")
    except ImportError as error:
        raise SourceError(
            path,
            "a version 7.3 MATLAB file; install h5py (`pip install h5py`), or save it in MATLAB with "
            "`save(file, '-v7')`",
        ) from error
    with h5py.File(path, "r") as file:
        # HDF5 holds MATLAB's arrays transposed.
        return {name: np.asarray(item).T for name, item in file.items() if isinstance(item, h5py.Dataset)}
