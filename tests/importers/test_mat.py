"""MATLAB files through a map of variables, with the layout of the EMPS benchmark."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io

import trundle
from trundle.importers import Imported, read

Import = Callable[[Path, str, dict[str, Any]], Imported]
EXAMPLE = Path(__file__).parents[2] / "configs" / "import" / "mat.toml"


def write_axis(path: Path, **changes: Any) -> Path:
    """Write a file with the variables of the benchmark: column vectors and a scalar gain."""
    t = np.arange(50) / 1000
    variables: dict[str, Any] = {
        "t": t,
        "qm": 0.1 * t**2,
        "vir": np.cos(t),
        "gtau": 35.15,
        "kp": 160.0,
    } | changes
    scipy.io.savemat(path, {name: np.atleast_2d(value).T for name, value in variables.items()})
    return path


def test_the_example_map_multiplies_gain_and_voltage(tmp_path: Path) -> None:
    got = read(write_axis(tmp_path / "run.mat"), "mat", EXAMPLE)
    table = trundle.Recording(got.metadata, got.episodes).episodes["episode_00"]
    np.testing.assert_allclose(table["force_x"], 35.15 * np.cos(table["t"]))
    np.testing.assert_allclose(table["object_x"], 0.1 * table["t"] ** 2)


def test_structs_and_matrices(imported: Import, tmp_path: Path) -> None:
    t = np.arange(5.0)
    pose = np.column_stack([t, 10 * t, 0 * t])
    scipy.io.savemat(
        tmp_path / "log.mat", {"log": {"t": 1e3 * t, "pose": pose, "f": np.column_stack([t, t, t])}}
    )
    columns = {
        name: {"name": "log.pose", "index": k, "unit": unit}
        for k, (name, unit) in enumerate(
            {"object_x": "mm", "object_y": "cm", "object_theta": "rad"}.items(), 1
        )
    }
    columns |= {name: {"name": "log.f", "index": 1} for name in ("force_x", "force_y", "torque_z")}
    settings = {"time": {"name": "log.t", "unit": "ms"}, "columns": columns}
    table = imported(tmp_path / "log.mat", "mat", settings).episodes["episode_00"]
    np.testing.assert_allclose(table["t"], t)
    np.testing.assert_allclose(table["object_x"], t / 1000)
    np.testing.assert_allclose(table["object_y"], t / 10)


@pytest.mark.parametrize(
    ("columns", "message"),
    [
        ({"object_x": "q"}, r"run\.mat: no variable `q`; the file contains `gtau` \(1, 1\), `kp`"),
        ({"object_x": {"product": ["qm", "m"]}}, r"`m` is a 2 by 3 matrix; choose a column: `index = 1`"),
        ({"object_x": {"name": "m", "index": 4}}, r"`m` of the shape \(2, 3\) has no column 4"),
        (
            {"object_x": {"product": ["qm", "two"]}},
            r"`two` has 2 samples, but other factors of .* 50",
        ),
        ({"object_x": "two"}, r"object_x has 2 samples and its time 50; give the time of object in `times`"),
        ({"object_x": "words"}, r"variable `words` is not an array of numbers"),
        ({"object_x": "qm.left"}, r"`qm.left`: no field 'left'; the fields are none"),
    ],
)
def test_mismatches_are_named(
    imported: Import, tmp_path: Path, columns: dict[str, Any], message: str
) -> None:
    file = write_axis(tmp_path / "run.mat", m=np.ones((3, 2)), two=np.ones(2), words=np.array(["a", "b"]))
    with pytest.raises(ValueError, match=message):
        imported(file, "mat", {"time": "t", "columns": columns})


def test_version_7_3_needs_h5py(imported: Import, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The first 128 bytes say that the rest is HDF5."""
    text = b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM"
    (tmp_path / "new.mat").write_bytes(text + b"\x89HDF\r\n\x1a\n" + bytes(64))
    monkeypatch.setitem(sys.modules, "h5py", None)
    with pytest.raises(ValueError, match=r"version 7\.3 need h5py: .*\[matlab\].* `save\(file, '-v7'\)`"):
        imported(tmp_path / "new.mat", "mat", {"time": "t", "columns": {"object_x": "x"}})


def test_another_file_format_is_refused(imported: Import, tmp_path: Path) -> None:
    (tmp_path / "run.mat").write_text("t,x\n0,1\n" * 40)
    with pytest.raises(ValueError, match=r"run\.mat: not a readable MATLAB file"):
        imported(tmp_path / "run.mat", "mat", {"time": "t", "columns": {"object_x": "x"}})


def test_version_7_3_with_h5py(imported: Import, tmp_path: Path) -> None:
    """MATLAB writes its header into the first 512 bytes and arrays transposed."""
    h5py = pytest.importorskip("h5py", reason="h5py is optional: it reads MATLAB files of version 7.3")
    path = tmp_path / "new.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        file["t"] = np.arange(4.0)[None, :]
        file["log/pose"] = np.arange(12.0).reshape(3, 4)
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")
    columns = {name: {"name": "log.pose", "index": k} for k, name in enumerate(("object_x", "force_x"), 2)}
    table = imported(path, "mat", {"time": "t", "columns": columns}).episodes["episode_00"]
    np.testing.assert_array_equal(table["object_x"], [4.0, 5.0, 6.0, 7.0])
