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

    def vector(self, name: str, index: int | None = None) -> Floats:
        """Return one numeric variable as a vector.

        Parameters
        ----------
        name : str
            A variable, or a struct's field as `log.position`.
        index : int, optional
            Column of a matrix, from 1. Without it the variable is a vector, or a scalar of length 1.
        """
        values = self._numbers(name)
        if index is None and values.ndim == 2 and min(values.shape) > 1:
            raise SourceError(
                self.path,
                f"`{name}` is a {values.shape[0]} by {values.shape[1]} matrix; say which column: `index = 1`",
            )
        if index is None:
            return values.ravel(order="F")
        if values.ndim != 2 or not 1 <= index <= values.shape[1]:
            raise SourceError(self.path, f"`{name}` of the shape {values.shape} has no column {index}")
        return values[:, index - 1]

    def _numbers(self, name: str) -> Floats:
        value = self._variable(name)
        try:
            return np.asarray(value, dtype=np.float64)
        except (TypeError, ValueError) as error:
            raise SourceError(
                self.path,
                f"variable `{name}` is no array of numbers; export its field as a variable of its own",
            ) from error

    def _variable(self, name: str) -> Any:
        if name in self._variables:
            return self._variables[name]
        variable, *fields = name.split(".")
        if variable not in self._variables:
            raise SourceError(self.path, f"no variable `{variable}`; the file holds {self._listing()}")
        value = self._variables[variable]
        for field in fields:
            known = getattr(getattr(value, "dtype", None), "names", None) or ()
            if field not in known:
                raise SourceError(
                    self.path, f"`{name}`: no field {field!r}; there are {', '.join(known) or 'none'}"
                )
            value = value[field].flat[0]
        return value

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
    variables: dict[str, Any] = {}

    def keep(name: str, item: Any) -> None:
        # A struct is a group, and MATLAB's own tables of references begin with a hash.
        if isinstance(item, h5py.Dataset) and not name.startswith("#"):
            variables[name.replace("/", ".")] = np.asarray(item).T

    try:
        with h5py.File(path, "r") as file:
            file.visititems(keep)
    except OSError as error:
        raise SourceError(path, f"not a MATLAB file that can be read ({error})") from error
    return variables
