"""Variables of MATLAB files of all versions."""

from __future__ import annotations

import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from trundle._native import TrundleError
from trundle._optional import require
from trundle.importers import matlab
from trundle.importers.layout import Floats, SourceError
from trundle.importers.matlab import Cell, DamagedError, HDF5Error, Other, Struct, Value

__all__ = ["MatFile"]

HDF5_READER = Path(__file__).with_name("hdf5_child.py")
REMEDY = "save it again in MATLAB with `save(file, '-v7')`"
HDF5_TIMEOUT_S = 120
"""Maximum time for reading a file of version 7.3, s."""


class MatFile:
    """Numeric variables of a `.mat` file.

    Parameters
    ----------
    path : Path
        A file of version 4 to 7, or 7.3 (HDF5) if `h5py` is installed.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        self._variables = _load(path)

    def vector(self, name: str, index: int | None = None) -> Floats:
        """Return one numeric variable as a vector.

        Parameters
        ----------
        name : str
            A variable, or a field of a struct such as `log.position`.
        index : int, optional
            Column of a matrix, from 1. Without it the variable must be a vector or a scalar.
        """
        values = self._numbers(name)
        if index is None and values.ndim == 2 and min(values.shape) > 1:
            raise SourceError(
                self.path,
                f"`{name}` is a {values.shape[0]} by {values.shape[1]} matrix; choose a column: `index = 1`",
            )
        if index is None:
            return values.ravel(order="F")
        if values.ndim != 2 or not 1 <= index <= values.shape[1]:
            raise SourceError(self.path, f"`{name}` of the shape {values.shape} has no column {index}")
        return values[:, index - 1]

    def matrix(self, name: str, order: Sequence[str]) -> Floats:
        """Return a matrix, shape (n, k) with a column for each name in `order`, also from (k, n)."""
        values, width = self._numbers(name), len(order)
        if values.ndim == 2 and values.shape[1] == width:
            return values
        if values.ndim == 2 and values.shape[0] == width:
            return values.T
        raise SourceError(
            self.path,
            f"`{name}` of the shape {values.shape} has no dimension of {width}, the number of joints in "
            f"`order` (by default `joints`): {', '.join(order)}; give `order`, the joints in the order of "
            "its columns",
        )

    def cells(self, name: str) -> list[str]:
        """Return a numeric vector as text."""
        return [f"{value:g}" for value in self.vector(name)]

    def cell(self, name: str) -> list[Floats]:
        """Return the matrices in a cell array, in the order of its columns."""
        value = self._variable(name)
        if not isinstance(value, Cell) or not all(isinstance(each, np.ndarray) for each in value.values):
            raise SourceError(self.path, f"variable `{name}` is not a cell array of matrices")
        return [each for each in value.values if isinstance(each, np.ndarray)]

    def _numbers(self, name: str) -> Floats:
        value = self._variable(name)
        if not isinstance(value, np.ndarray):
            raise SourceError(
                self.path,
                f"variable `{name}` is not an array of numbers; export its field as a separate variable",
            )
        return value

    def _variable(self, name: str) -> Value:
        if name in self._variables:
            return self._variables[name]
        variable, *fields = name.split(".")
        if variable not in self._variables:
            raise SourceError(self.path, f"no variable `{variable}`; the file contains {self._listing()}")
        value = self._variables[variable]
        for field in fields:
            known = value.fields if isinstance(value, Struct) else {}
            if field not in known:
                raise SourceError(
                    self.path, f"`{name}`: no field {field!r}; the fields are {', '.join(known) or 'none'}"
                )
            value = known[field]
        return value

    def _listing(self) -> str:
        return ", ".join(f"`{name}` {value.shape}" for name, value in sorted(self._variables.items()))


def _load(path: Path) -> dict[str, Value]:
    if not path.is_file():
        raise SourceError(path, "no such file")
    try:
        return matlab.read(path.read_bytes())
    except HDF5Error:
        return _load_hdf5(path)
    except DamagedError as error:
        raise _unreadable(path, str(error)) from error


def _unreadable(path: Path, reason: str) -> SourceError:
    return SourceError(path, f"not a readable MATLAB file ({reason}); {REMEDY}")


def _load_hdf5(path: Path) -> dict[str, Value]:
    """Read a file of version 7.3 in another process, because a damaged file may crash the HDF5 library."""
    try:
        require("h5py", "matlab", "MATLAB files of version 7.3")
    except TrundleError as error:
        raise SourceError(path, f"{error}, or {REMEDY}") from error
    limit = matlab.BASE_MEMORY_BYTES + matlab.MEMORY_PER_FILE_BYTE * path.stat().st_size
    with tempfile.TemporaryDirectory() as place:
        target = Path(place) / "variables.npz"
        command = [sys.executable, "-I", str(HDF5_READER), str(path), str(target), str(limit)]
        try:
            done = subprocess.run(
                command, capture_output=True, text=True, timeout=HDF5_TIMEOUT_S, check=False
            )
        except subprocess.TimeoutExpired as error:
            raise _unreadable(path, f"reading takes more than {HDF5_TIMEOUT_S} s") from error
        if done.returncode == 3:
            raise _unreadable(path, done.stdout.strip())
        if done.returncode != 0 or not target.exists():
            raise _unreadable(path, "the HDF5 library crashes")
        with np.load(target, allow_pickle=False) as found:
            return {name[2:]: _value(found[name]) for name in found.files}


def _value(array: Floats) -> Value:
    return array if array.dtype == np.float64 else Other(array.shape, "text")
