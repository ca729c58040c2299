"""Damaged logs of joints are read, or refused with a message; no other exception escapes."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from tests.importers import test_joints_csv, test_lerobot, test_pendulum, test_so101, test_xl330
from tests.importers.joint_bags import states, write_joint_bag
from tests.importers.mechanisms import check_joints
from trundle import TrundleError
from trundle.importers import MapError, SourceError, read

MODEL = {"mechanism": {"model": "robot.xml"}}
AXIS = {"mechanism": {"axis": "hinge"}}
HINGE: dict[str, Any] = {"joints": ["elbow"], "recording": AXIS}
LAYOUTS: dict[str, tuple[str, str, dict[str, Any]]] = {
    "csv": ("log.csv", "csv", test_joints_csv.LISTS),
    "xl330": ("xl330.json", "xl330", {}),
    "so101": ("so101/swing/state_motor.csv", "so101", {"joint": "Pitch"}),
    "so101 joints": ("so101/swing/joint_list.txt", "so101", {"joint": "Pitch"}),
    "pendulum": ("double.mat", "pendulum", {}),
    "lerobot table": ("set/data/chunk-000/file-000.parquet", "lerobot", test_lerobot.SETTINGS),
    "lerobot info": ("set/meta/info.json", "lerobot", test_lerobot.SETTINGS),
    "model": ("robot.xml", "csv", test_joints_csv.LISTS),
}
"""File to damage, layout and map."""
SOURCES = {"so101": "so101", "lerobot": "set"}
PIECES = [b"nan", b"1e999", b",", b'"', b"[", b"{", b"-", b"\n", b"null", b"9"]
"""Bytes that are special in text files."""
DAMAGES = 80
"""Of each file."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a whole source of each layout."""
    place = tmp_path_factory.mktemp("logs")
    (place / "robot.xml").write_text(test_joints_csv.MODEL)
    test_joints_csv.lists(place / "log.csv")
    test_xl330.write(place / "xl330.json")
    test_so101.write(place / "so101", "swing", 1.0)
    test_pendulum.write(place / "double.mat")
    test_lerobot.write(place / "set")
    return place


def damaged(content: bytes, draw: random.Random) -> bytes:
    """Cut the content, or replace or insert some bytes."""
    for _ in range(draw.randint(1, 3)):
        at, piece = (
            draw.randrange(len(content) + 1),
            draw.choice([*PIECES, draw.randbytes(draw.randint(1, 4))]),
        )
        match draw.randrange(3):
            case 0:
                content = content[:at]
            case 1:
                content = content[:at] + piece + content[at + len(piece) :]
            case _:
                content = content[:at] + piece + content[at:]
    return content


@pytest.mark.parametrize("case", LAYOUTS)
def test_a_damaged_file_is_read_or_refused(folder: Path, monkeypatch: pytest.MonkeyPatch, case: str) -> None:
    name, layout, source_map = LAYOUTS[case]
    monkeypatch.chdir(folder)
    file, draw, refused = folder / name, random.Random(0), 0
    whole = file.read_bytes()
    source = folder / SOURCES.get(layout, "log.csv" if case == "model" else name)
    for _ in range(DAMAGES):
        file.write_bytes(damaged(whole, draw))
        try:
            check_joints(read(source, layout, source_map))
        except (TrundleError, SourceError, MapError) as error:
            assert str(error) and "\n" not in str(error)
            refused += 1
    file.write_bytes(whole)
    check_joints(read(source, layout, source_map))
    assert refused > DAMAGES // 4


@pytest.mark.parametrize("storage", ["mcap", "sqlite3"])
def test_a_damaged_bag_is_read_or_refused(tmp_path: Path, storage: str) -> None:
    bag = write_joint_bag(tmp_path / "run", states(10), storage)
    (file,) = (path for path in bag.iterdir() if path.suffix in (".mcap", ".db3"))
    whole, rng = file.read_bytes(), np.random.default_rng(0)
    check_joints(read(file, "mcap", HINGE))
    for _ in range(60):
        data = np.frombuffer(whole, dtype=np.uint8).copy()
        data[rng.integers(len(data), size=10)] = rng.integers(256, size=10)
        file.write_bytes(data[: rng.integers(len(data) // 2, len(data) * 2)].tobytes())
        try:
            read(file, "mcap", HINGE)
        except (TrundleError, SourceError, MapError) as error:
            assert str(error)


maps = st.recursive(
    st.one_of(
        st.none(), st.booleans(), st.integers(-3, 3), st.floats(), st.sampled_from(["q", "elbow", "x", ""])
    ),
    lambda inner: st.one_of(
        st.lists(inner, max_size=3),
        st.dictionaries(
            st.sampled_from(
                ["joints", "columns", "lists", "q_elbow", "name", "unit", "path", "mechanism", "axis"]
            ),
            inner,
            max_size=3,
        ),
    ),
    max_leaves=6,
)


@settings(max_examples=150, suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(
    key=st.sampled_from(
        ["joints", "angle", "time", "columns", "lists", "order", "file", "episode", "recording"]
    ),
    value=maps,
)
def test_any_map_is_used_or_refused(folder: Path, key: str, value: Any) -> None:
    columns = {"q_elbow": {"name": "stamp", "unit": "deg"}}
    base = {"joints": ["elbow"], "skip_rows": 2, "time": "stamp", "columns": columns, "recording": AXIS}
    try:
        read(folder / "log.csv", "csv", base | {key: value})
    except (TrundleError, SourceError, MapError) as error:
        assert str(error)
