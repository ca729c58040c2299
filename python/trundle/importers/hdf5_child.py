"""Read the datasets of a MATLAB 7.3 file in a separate process: `python hdf5_child.py FILE OUT.npz LIMIT`.

The HDF5 library trusts its input, so a damaged file may crash the process that reads it. This file does not
import trundle, for a fast start. It exits with status 0, or with 3 and a message on standard output.
"""

from __future__ import annotations

import importlib
import sys
from typing import Any

import numpy as np

__all__: list[str] = []

h5py: Any = importlib.import_module("h5py")


def main(source: str, target: str, limit: int) -> str | None:
    """Write all datasets of `source` to `target`; return an error message, or None."""
    found: dict[str, Any] = {}
    left = limit

    def keep(name: str, item: Any) -> str | None:
        nonlocal left
        # A struct is a group. Names of MATLAB's internal reference tables begin with a hash.
        if not isinstance(item, h5py.Dataset) or name.startswith("#"):
            return None
        number = item.dtype.kind in "iufb"
        left -= 8 * item.size if number else 0
        if left < 0:
            return f"its variables need more than {limit >> 20} MiB; save only the variables that are needed"
        # Of other data only the shape is kept.
        found[name.replace("/", ".")] = (
            np.asarray(item, dtype=np.float64).T if number else np.zeros(item.shape[::-1], dtype="S1")
        )
        return None

    try:
        with h5py.File(source, "r") as file:
            trouble: str | None = file.visititems(keep)
    except Exception as error:  # h5py raises many types; report its message
        return str(error).splitlines()[0] if str(error) else type(error).__name__
    if trouble is None:
        np.savez(target, **{f"v_{name}": value for name, value in found.items()})
    return trouble


if __name__ == "__main__":
    try:
        import resource

        # Allow for the library itself and for a copy of the data.
        most = 3 * int(sys.argv[3]) + (1 << 30)
        resource.setrlimit(resource.RLIMIT_AS, (most, most))
    except (ImportError, ValueError, OSError):
        pass
    complaint = main(sys.argv[1], sys.argv[2], int(sys.argv[3]))
    if complaint is not None:
        print(complaint)
        sys.exit(3)
