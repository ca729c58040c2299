"""Logs of the pneumatic seal: invented files of their layout, and the real data."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import trundle
from tests.importers.conftest import Import
from tests.importers.mechanisms import check_joints
from trundle.importers import Imported, read

AREA = np.pi * 0.025**2 / 4
FRICTION = 4.0
STEP = 10


def rows(pairs: int = 4, bar: float = 3.0) -> np.ndarray:
    """Return a log: strokes of 39 mm and 4 s each, with dry friction and pressure on the load cell."""
    t = np.arange(0, pairs * 8000, STEP, dtype=float)
    phase = (t / 4000) % 2
    position = -1.5 + 39.0 * np.where(phase < 1, phase, 2 - phase)
    pressure = bar + 0.05 * np.sin(t / 300)
    force = pressure * 1e5 * AREA + FRICTION * np.where(phase < 1, 1, -1)
    zeros = np.zeros_like(t)
    return np.column_stack([t, zeros, zeros, zeros, position, pressure, force])


def write(path: Path, table: np.ndarray) -> Path:
    text = "".join("\t".join(f"{value:.3f}" for value in row) + "\r\n" for row in table)
    path.write_bytes(text.encode("ascii"))
    return path


def one(tmp_path: Path, table: np.ndarray, name: str = "O-ring_3bar.csv") -> Imported:
    return read(write(tmp_path / name, table), "pneumatic-seal")


def test_a_log_becomes_stroke_pairs_on_a_rail(tmp_path: Path) -> None:
    got = one(tmp_path, rows())
    recording = trundle.Recording(got.metadata, got.episodes)
    assert recording.metadata["object"]["dof"] == ["x"]
    assert recording.metadata["split"]["held_out"] == ["episode_02", "episode_03"]
    assert recording.metadata["notes"]["licence"] == "CC0 1.0"
    assert list(recording.episodes) == [f"episode_{k:02}" for k in range(4)]
    for table in got.episodes.values():
        assert table["t"][0] == 0.0
        assert np.ptp(table["object_x"]) == pytest.approx(0.039, abs=2e-4)
        assert np.argmax(table["object_x"]) == pytest.approx(len(table["t"]) / 2, abs=2)
        forth = np.arange(len(table["t"])) < np.argmax(table["object_x"]) - 1
        np.testing.assert_allclose(table["force_x"][forth][2:], FRICTION, atol=0.03)
        np.testing.assert_allclose(table["force_x"][~forth][4:-2], -FRICTION, atol=0.03)
        assert np.median(table["note_pressure"]) == pytest.approx(3e5, rel=0.02)


def test_no_sample_is_lost(tmp_path: Path) -> None:
    table = rows()
    got = one(tmp_path, table)
    assert sum(len(episode["t"]) for episode in got.episodes.values()) == len(table)
    assert got.remarks == []


def test_short_gaps_stay_and_long_ones_split(tmp_path: Path) -> None:
    table = rows()
    short = np.delete(table, slice(100, 130), axis=0)
    got = one(tmp_path, short)
    assert np.max(np.diff(got.episodes["episode_00"]["t"])) == pytest.approx(0.31)
    assert got.remarks == []
    long = np.delete(table, slice(10, 160), axis=0)
    got = one(tmp_path, long)
    assert len(got.episodes["episode_00"]["t"]) == len(got.episodes["episode_01"]["t"]) - 160
    assert got.remarks == ["O-ring_3bar.csv: 10 rows of pair 1 omitted because of a gap of more than 0.5 s"]


def test_an_incomplete_stroke_is_omitted(tmp_path: Path) -> None:
    got = one(tmp_path, rows()[:-300])
    assert len(got.episodes) == 3
    assert got.remarks == ["O-ring_3bar.csv: 500 rows after the last complete pair of strokes omitted"]


def test_several_pressures_make_one_recording(tmp_path: Path, imported: Import) -> None:
    for bar in (1, 3):
        write(tmp_path / f"O-ring_{bar}bar.csv", rows(bar=bar))
    settings = {"files": ["O-ring_1bar", "O-ring_3bar"], "held_out": 1, "name": "two pressures"}
    got = imported(tmp_path, "pneumatic-seal", settings)
    recording = trundle.Recording(got.metadata, got.episodes)
    assert recording.name == "two pressures"
    assert recording.metadata["split"]["held_out"] == ["O-ring_1bar_03", "O-ring_3bar_03"]
    assert np.median(got.episodes["O-ring_1bar_00"]["note_pressure"]) == pytest.approx(1e5, rel=0.05)


def test_the_bore_depends_on_the_seal(tmp_path: Path, imported: Import) -> None:
    table = rows()
    narrow, wide = one(tmp_path, table), one(tmp_path, table, "X-ring257_3bar.csv")
    less = narrow.episodes["episode_00"]["force_x"] - wide.episodes["episode_00"]["force_x"]
    area = np.pi * (0.0257**2 - 0.025**2) / 4
    np.testing.assert_allclose(less, area * wide.episodes["episode_00"]["note_pressure"], rtol=1e-6)
    given = imported(tmp_path / "O-ring_3bar.csv", "pneumatic-seal", {"bore": 0.0257})
    np.testing.assert_allclose(
        given.episodes["episode_00"]["force_x"], wide.episodes["episode_00"]["force_x"]
    )


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        (
            {},
            r"a folder: give one of its files, or a map.*the logs are O-ring_3bar, X-ring257_3bar",
        ),
        (
            {"files": ["O-ring_3bar", "X-ring257_3bar"]},
            "of the seals O-ring, X-ring257: choose logs of one seal",
        ),
        ({"files": ["O-ring_3bar", "O-ring_3bar"]}, "list each log once"),
        ({"files": ["O-ring_5bar"]}, r"O-ring_5bar\.csv: no such file"),
        ({"files": ["O-ring_3bar"], "held_out": 4}, "4 pairs of strokes and `held_out` = 4: no pair to fit"),
        ({"files": ["O-ring_3bar"], "held_out": 0}, "`held_out` = 0: must be at least 1 pair"),
        ({"files": ["O-ring_3bar"], "bore": 25.0}, r"`bore` = 25.0: give the bore of the cylinder in m"),
    ],
)
def test_incompatible_files_are_refused(
    tmp_path: Path, imported: Import, settings: dict[str, object], message: str
) -> None:
    for name in ("O-ring_3bar", "X-ring257_3bar"):
        write(tmp_path / f"{name}.csv", rows())
    with pytest.raises(ValueError, match=message):
        imported(tmp_path, "pneumatic-seal", settings)


def test_a_damaged_file_is_refused_with_its_row(tmp_path: Path) -> None:
    table = rows()
    table[50, 0] = table[49, 0]
    with pytest.raises(ValueError, match=r"row 51: time 490 ms is not greater than in the row before"):
        one(tmp_path, table)
    with pytest.raises(ValueError, match=r"row 1 = .*must contain 7 numbers"):
        one(tmp_path, rows()[:, :6])
    still = rows()
    still[:, 4] = 0.0
    with pytest.raises(ValueError, match=r"no pair of strokes"):
        one(tmp_path, still)
    with pytest.raises(ValueError, match=r"seal `Y-ring` is not one of O-ring, X-ring257; give its `bore`"):
        one(tmp_path, rows(), "Y-ring_3bar.csv")


@pytest.mark.parametrize("seal", ["O-ring", "X-ring257"])
@pytest.mark.parametrize("bar", [1, 3, 5, 7])
def test_friction_opposes_the_motion_in_real_logs(
    real_data: Callable[[str], Path], seal: str, bar: int
) -> None:
    """Signs: the remaining force on the piston drives every stroke, forward and back."""
    got = read(real_data("pneumatic-seal") / f"{seal}_{bar}bar.csv", "pneumatic-seal")
    assert len(trundle.Recording(got.metadata, got.episodes).episodes) == 10
    for table in got.episodes.values():
        assert np.median(table["note_pressure"]) == pytest.approx(bar * 1e5, rel=0.05)
        assert np.max(np.diff(table["t"])) < 0.31
        turn = int(np.argmax(table["object_x"]))
        forth, back = table["force_x"][20 : turn - 20], table["force_x"][turn + 20 : -20]
        assert np.mean(forth) > 3.0 and np.mean(back) < -2.0


def test_friction_grows_with_pressure_in_real_logs(real_data: Callable[[str], Path]) -> None:
    """The difference between strokes forward and back is twice the friction, as in the thesis."""

    def friction(path: Path) -> float:
        force = np.concatenate([table["force_x"] for table in read(path, "pneumatic-seal").episodes.values()])
        return float(np.mean(np.abs(force)))

    for seal in ("O-ring", "X-ring257"):
        found = [friction(real_data("pneumatic-seal") / f"{seal}_{bar}bar.csv") for bar in (1, 3, 5, 7)]
        assert np.all(np.diff(found) > 0), found


def test_format_2_is_a_slide_with_pressure_as_known_effort(tmp_path: Path, imported: Import) -> None:
    path = write(tmp_path / "O-ring_3bar.csv", rows())
    rail, got = read(path, "pneumatic-seal"), imported(path, "pneumatic-seal", {"format": 2})
    check_joints(got)
    assert got.metadata["mechanism"] == {"axis": "slide", "joints": ["piston"], "imposed": True}
    assert got.metadata["split"] == rail.metadata["split"]
    for name, table in got.episodes.items():
        old = rail.episodes[name]
        np.testing.assert_array_equal(table["q_piston"], old["object_x"])
        np.testing.assert_array_equal(table["load_piston"], old["note_pressure"])
        np.testing.assert_allclose(table["effort_piston"] + table["known_piston"], old["force_x"], atol=1e-9)
        np.testing.assert_allclose(table["known_piston"], -AREA * table["load_piston"])
