"""Damaged MATLAB files are read or refused; none crashes the process or takes much memory."""

from __future__ import annotations

import io
import random
import tracemalloc
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import scipy.io

import trundle
from trundle.importers import SourceError, matfile, matlab, read
from trundle.importers.matfile import MatFile

EXAMPLE = Path(__file__).parents[2] / "configs" / "import" / "mat.toml"
T = np.arange(40) / 100
VARIABLES: dict[str, Any] = {
    "t": T[:, None],
    "qm": 0.1 * T[:, None] ** 2,
    "vir": np.cos(T)[:, None].astype(np.float32),
    "gtau": np.array([[35]], dtype=np.int16),
}
RICH: dict[str, Any] = {
    **VARIABLES,
    "log": {"pose": np.ones((3, 4)), "inner": {"deep": np.arange(5.0)}},
    "words": np.array(["some", "words"]),
    "cell": np.array([[1.0], [np.ones(3)]], dtype=object),
    "wave": np.exp(1j * T),
    "flags": T > 0.2,
}
MUTATIONS = 1500
"""Of each of the three files."""


def saved(variables: dict[str, Any], **options: Any) -> bytes:
    file = io.BytesIO()
    scipy.io.savemat(file, variables, **options)
    return file.getvalue()


FILES = {
    "version 4": saved(VARIABLES, format="4"),
    "version 6": saved(RICH),
    "version 7": saved(RICH, do_compression=True),
}


def mutated(content: bytes, random: random.Random) -> bytes:
    """Flip bits, overwrite lengths, cut, or repeat a part."""
    data = bytearray(content)
    for _ in range(random.randint(1, 4)):
        at = random.randrange(len(data))
        match random.randrange(5):
            case 0:
                data[at] ^= 1 << random.randrange(8)
            case 1:
                data[at] = random.choice([0, 1, 14, 15, 127, 128, 255])
            case 2:
                at = 4 * (at // 4)
                data[at : at + 4] = random.choice([0, 1, 2**31 - 1, 2**31, 2**32 - 1]).to_bytes(4, "little")
            case 3:
                del data[at + 1 :]
            case _:
                data[at:at] = data[at : at + random.randrange(1, 64)]
    return bytes(data)


def outcome(path: Path, use: Callable[[MatFile], Any]) -> str:
    try:
        use(MatFile(path))
    except SourceError as error:
        message = str(error)
        assert message.startswith(f"{path}: ") and "\n" not in message, message
        return message
    return ""


def use(file: MatFile) -> None:
    for name in ("t", "qm", "vir", "gtau", "log.pose", "log.inner.deep"):
        if name.split(".")[0] in file._variables:
            file.vector(name, index=1)


@pytest.mark.parametrize("version", FILES)
def test_a_damaged_file_is_read_or_refused(version: str, tmp_path: Path) -> None:
    draw, path = random.Random(0), tmp_path / "run.mat"
    refused = 0
    for _ in range(MUTATIONS):
        path.write_bytes(mutated(FILES[version], draw))
        message = outcome(path, use)
        refused += "save it again in MATLAB" in message
    assert MUTATIONS // 20 < refused < MUTATIONS


def test_a_damaged_file_never_crashes_an_import(tmp_path: Path) -> None:
    draw, path, whole = random.Random(1), tmp_path / "run.mat", FILES["version 6"]
    path.write_bytes(whole)
    got = read(path, "mat", EXAMPLE)
    assert trundle.Recording(got.metadata, got.episodes).episodes
    for _ in range(200):
        path.write_bytes(mutated(whole, draw))
        try:
            got = read(path, "mat", EXAMPLE)
            trundle.Recording(got.metadata, got.episodes)
        except ValueError as error:
            assert str(error)


def test_a_decompression_bomb_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """100 MB of zeros in 100 kB."""
    monkeypatch.setattr(matlab, "BASE_MEMORY_BYTES", 1 << 20)
    path = tmp_path / "run.mat"
    whole = saved({"t": np.zeros((1, 1))})
    packed = zlib.compress(bytes(100_000_000))
    path.write_bytes(
        whole[: matlab.HEADER_BYTES] + (15).to_bytes(4, "little") + len(packed).to_bytes(4, "little") + packed
    )
    tracemalloc.start()
    with pytest.raises(SourceError, match=r"its variables need more than \d+ MiB, .*save it uncompressed"):
        MatFile(path)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert peak < 3 * (matlab.BASE_MEMORY_BYTES + matlab.MEMORY_PER_FILE_BYTE * len(packed))


def test_version_7_3_is_read_in_a_separate_process(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    h5py = pytest.importorskip("h5py", reason="h5py is optional: it reads MATLAB files of version 7.3")
    path = tmp_path / "new.mat"
    with h5py.File(path, "w", userblock_size=512) as file:
        file["t"] = np.arange(4.0)[None, :]
        # A dataset of 800 GB without stored chunks.
        file.create_dataset("huge", (10**11,), dtype="f8", chunks=(1000,))
    with path.open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(124) + b"\x00\x02IM")
    assert "its variables need more than" in outcome(path, use)
    draw, whole = random.Random(2), path.read_bytes()
    for _ in range(3):
        path.write_bytes(whole[:512] + mutated(whole[512:], draw))
        outcome(path, use)
    # A library that crashes its process.
    fatal = tmp_path / "fatal.py"
    fatal.write_text("import os\nos.abort()\n")
    monkeypatch.setattr(matfile, "HDF5_READER", fatal)
    assert "the HDF5 library crashes" in outcome(path, use)
