"""Logs of the XL330 servo: invented files of their layout, and the real data."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.importers.conftest import Import
from tests.importers.mechanisms import check_joints
from trundle.importers import read
from trundle.importers.xl330_log import mask_wraps

COUNT = 60


def write(path: Path, duty: Any = 100.0, **changes: Any) -> Path:
    """Write a log with a duty in steps of the register, resampled as the real ones."""
    raw = np.broadcast_to(duty, COUNT) % 65536
    entries = [
        {
            "position": 0.01 * k,
            "speed": 2.0,
            "load": float(raw[k]),
            "input_volts": 7.0 + 0.1 * (k % 2),
            "temp": 30,
            "goal_position": 0.02 * k,
            "torque_enable": k < 40,
            "timestamp": 5.0 + 0.005 * k,
        }
        for k in range(COUNT)
    ]
    content = {"mass": 0.5, "length": 0.2, "kp": 100, "vin": 7.4, "trajectory": "sin", "entries": entries}
    path.write_text(json.dumps(content | changes))
    return path


def test_a_log_becomes_a_driven_pendulum(tmp_path: Path) -> None:
    got = read(write(tmp_path / "log.json", duty=-88.5), "xl330")
    check_joints(got)
    mechanism = got.metadata["mechanism"]
    assert mechanism["inertia"] == pytest.approx(0.02)
    assert mechanism["gravity_torque"] == pytest.approx(0.5 * 9.81 * 0.2)
    assert got.metadata["effort"] == {"source": "voltage", "gain": "free"}
    assert got.metadata["delay"] == {"v": 0.02}
    table = got.episodes["log"]
    np.testing.assert_allclose(table["t"], 0.005 * np.arange(COUNT), atol=1e-12)
    np.testing.assert_allclose(table["effort_arm"], -0.1 * (7.0 + 0.1 * (np.arange(COUNT) % 2)))
    np.testing.assert_array_equal(table["on_arm"], np.arange(COUNT) < 40)


@pytest.mark.parametrize("offset", [0.0, 1.0, 3.0, 30.0])
def test_values_between_two_sides_of_a_wrap_are_masked(offset: float) -> None:
    """The unsigned register is resampled from 5.3 to 5 ms, and its wraps with it."""
    raw_t, t = np.arange(400) * 5.3e-3, np.arange(400) * 5e-3

    def duty(t: Any) -> Any:
        return np.round(300.0 * np.sin(5.0 * t) + offset)

    got, count = mask_wraps(np.interp(t, raw_t, duty(raw_t) % 65536))
    wrong = np.isnan(got)
    wraps = np.sum(np.abs(np.diff(duty(raw_t[raw_t < 2.0]) % 65536)) > 1000)
    assert wraps <= count == np.sum(wrong) <= 3 * wraps
    np.testing.assert_allclose(got[~wrong], np.interp(t, raw_t, duty(raw_t))[~wrong], atol=1e-6)


def test_saturation_and_steps_of_the_duty_are_kept() -> None:
    raw = np.repeat([0.0, 885.0, 64651.0, 0.0, 65000.0], 5)
    got, count = mask_wraps(raw)
    assert count == 0
    np.testing.assert_array_equal(got[::5], [0.0, 885.0, -885.0, 0.0, -536.0])


def test_logs_of_a_folder_with_another_gain_and_load(tmp_path: Path, imported: Import) -> None:
    for k in range(6):
        write(tmp_path / f"log_{k}.json", kp=100 * (1 + (k > 2)))
    (tmp_path / "published.json").write_text('{"kt": 0.3}')
    got = read(tmp_path, "xl330")
    check_joints(got)
    assert got.metadata["split"]["held_out"] == ["log_4"]
    assert "episode" not in got.metadata and got.metadata["notes"]["logs"]["log_5"]["kp"] == 200
    target = imported(tmp_path, "xl330", {"drive": "target", "torque_per_volt": 0.1, "held_out": []})
    check_joints(target)
    assert "effort_arm" not in target.episodes["log_0"] and "effort" not in target.metadata
    stiffness = 0.74 * 100 * 4096 / (2 * np.pi) / (256 * 885)
    assert target.metadata["target"]["stiffness"] == pytest.approx(stiffness)
    assert sorted(target.metadata["episode"]) == ["log_3", "log_4", "log_5"]
    assert target.metadata["episode"]["log_3"]["stiffness"] == pytest.approx(2 * stiffness)
    write(tmp_path / "log_1.json", mass=0.7)
    loads = imported(tmp_path, "xl330", {"files": ["log_0", "log_1"]})
    check_joints(loads)
    assert loads.metadata["episode"]["log_1"]["model"] != loads.metadata["mechanism"]["model"]
    assert 'mass="0.7"' in loads.files[loads.metadata["episode"]["log_1"]["model"]]


@pytest.mark.parametrize(
    ("content", "message"),
    [
        ("[1]", "must be a JSON object with `entries`"),
        ("{", "not valid JSON"),
        ("{}", "no log with `entries`"),
        ('{"entries": [3]}', "`entries` must be a list of at least two samples"),
        ('{"entries": [3, 4]}', r"entry 1: timestamp = None must be a number"),
    ],
)
def test_other_files_are_refused(tmp_path: Path, content: str, message: str) -> None:
    (tmp_path / "log.json").write_text(content)
    with pytest.raises(ValueError, match=r"log\.json: " + message):
        read(tmp_path / "log.json", "xl330")


def test_damaged_logs_are_refused_with_their_entry(tmp_path: Path) -> None:
    content = json.loads(write(tmp_path / "log.json").read_text())
    for key, value, message in (
        ("timestamp", 5.01, r"entry 8: timestamp 5\.01 s is not after the one before"),
        ("speed", "fast", r"entry 8: speed = 'fast' must be a number"),
    ):
        entries = [dict(entry) for entry in content["entries"]]
        entries[7][key] = value
        (tmp_path / "log.json").write_text(json.dumps(content | {"entries": entries}))
        with pytest.raises(ValueError, match=message):
            read(tmp_path / "log.json", "xl330")
    with pytest.raises(ValueError, match="mass = -1 must be a positive number"):
        read(write(tmp_path / "log.json", mass=-1), "xl330")


def test_the_real_logs(real_data: Callable[[str], Path]) -> None:
    """The voltage is that of the firmware's position loop, and it accelerates towards the goal."""
    got = read(real_data("xl330"), "xl330")
    check_joints(got)
    assert len(got.episodes) == 10
    masked = sum(int(np.sum(np.isnan(table["effort_arm"]))) for table in got.episodes.values())
    assert 50 <= masked <= 60
    for name, table in got.episodes.items():
        kp = got.metadata["notes"]["logs"][name]["kp"]
        duty = kp * (table["target_arm"] - table["q_arm"]) * 4096 / (2 * np.pi) / (256 * 885)
        there = np.isfinite(table["effort_arm"]) & (table["on_arm"] == 1.0) & (np.abs(duty) < 0.9)
        volts = 7.4 * duty[there]
        assert np.corrcoef(volts, table["effort_arm"][there])[0, 1] > 0.97
        assert np.polyfit(volts, table["effort_arm"][there], 1)[0] == pytest.approx(1.0, abs=0.1)
