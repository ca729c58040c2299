"""CMU planar pushing: invented files of its layout, and physical checks of the real data."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

import trundle
from trundle.importers import read

Floats = NDArray[np.float64]
RealData = Callable[[str], Path]
CONFIGS = Path(__file__).resolve().parents[2] / "configs" / "import"
NAME = "hardboard__30_90_30_30_30_90.txt"


def write_pushes(path: Path, count: int = 5, lines: int | None = None) -> Path:
    """Write pushes of one second with 10 N along the tool's -x on the sensor from 0.5 s on."""
    text = [str(count)]
    for push in range(count):
        text += [f"{600 + push} 0 10 1 0 0 0", f"{601 + push} 0 10 1 0 0 0", "100"]
        for k in range(100):
            # Sensor axes are rotated by 45 degrees: the tool's x is between them.
            f = -10 / np.sqrt(2) * (k >= 50)
            text.append(f"{1000 + push * 10 + k / 100} {f + 0.5} {f - 0.25}")
        text.append("30")
        text += [f"{1000 + push * 10 + k / 30} {500 + k} 0 20 1 0 0 0" for k in range(30)]
    path.write_text("\n".join(text[:lines]) + "\n")
    return path


def test_pushes_become_episodes(tmp_path: Path) -> None:
    got = read(write_pushes(tmp_path / NAME), "cmu-planar-push")
    recording = trundle.Recording(got.metadata, got.episodes)
    assert list(recording.episodes) == [f"push_{k:02d}" for k in range(1, 6)]
    about = recording.metadata
    assert about["split"]["held_out"] == ["push_05"]
    assert about["object"]["support"] == [[0.03, 0.03], [0.09, 0.03], [0.03, 0.09]]
    table = recording.episodes["push_02"]
    assert table["t"][0] == 0.0
    np.testing.assert_allclose(table["object_x"][~np.isnan(table["object_x"])], [0.601, 0.602])
    # After the tare, 10 N along the tool's x remain, with the opposite sign on the sensor.
    force = np.column_stack([table["force_x"], table["force_y"]])
    start, end = about["wrench"]["precontact"]["push_02"]
    free = np.nanmean(force[(table["t"] >= start) & (table["t"] <= end)], axis=0)
    pushing = np.nanmean(force[table["t"] > 0.6], axis=0)
    np.testing.assert_allclose(pushing - free, [-10.0, 0.0], atol=1e-9)
    assert about["wrench"]["sign"] == "on_sensor"


@pytest.mark.parametrize(
    ("name", "lines", "message"),
    [
        (NAME, 80, r"ends after row 80, within a push; is the file complete"),
        ("hardboard__1_2.txt", None, r"the name's part '1_2' is neither `patch` nor six numbers"),
        ("log.txt", None, r"log\.txt: the file name must be surface__"),
    ],
)
def test_an_invalid_file_is_named(tmp_path: Path, name: str, lines: int | None, message: str) -> None:
    with pytest.raises(ValueError, match=message):
        read(write_pushes(tmp_path / name, lines=lines), "cmu-planar-push")


def test_an_invalid_row_is_named(tmp_path: Path) -> None:
    path = write_pushes(tmp_path / NAME)
    path.write_text(path.read_text().replace("601 0 10 1 0 0 0", "601 0 10 one 0 0 0", 1))
    with pytest.raises(ValueError, match=r"row 3 = '601 0 10 one 0 0 0': must contain 7 numbers"):
        read(path, "cmu-planar-push")


def test_at_most_every_second_push_is_held_out(tmp_path: Path) -> None:
    source = write_pushes(tmp_path / NAME)
    map_file = tmp_path / "map.toml"
    map_file.write_text("held_out_every = 2\n")
    assert read(source, "cmu-planar-push", map_file).metadata["split"]["held_out"] == ["push_02", "push_04"]
    map_file.write_text("held_out_every = 1\n")
    with pytest.raises(ValueError, match=r"map\.toml: `held_out_every` = 1: must be at least 2"):
        read(source, "cmu-planar-push", map_file)


def write_log(folder: Path, name: str, lost: int) -> None:
    """Write ten seconds at rest, without contact until the sixth; `lost` poses are invalid."""
    rng = np.random.default_rng(0)
    rows: dict[str, list[str]] = {"force": [], "pos": [], "robot": []}
    for k in range(1000):
        touching = 0.3 * (k >= 600) * (1 + rng.standard_normal())
        rows["force"] += [f"{100 + k / 100:.2f}", f"{touching + 0.1:.6f} {rng.normal(0, 1e-3):.6f} 1.0"]
    for k in range(500):
        # The tracked body has y up: it is rotated by 90° about the world's x.
        place = "668.54 -260.52" if k < lost else f"{530 + k / 100:.3f} 5"
        rows["pos"] += [f"{100 + k / 50:.2f}", f"{place} 45 0.70710678 0.70710678 0 0"]
        rows["robot"] += [f"{100 + k / 50:.2f}", f"{500 + k / 100:.2f} 0 15 1 0 0 0"]
    for kind, lines in rows.items():
        (folder / f"{name}_{kind}.txt").write_text("\n".join(lines) + "\n")


def test_logs_become_episodes(tmp_path: Path) -> None:
    write_log(tmp_path, "exp_1", 0)
    write_log(tmp_path, "exp_2", 7)
    got = read(tmp_path, "cmu-planar-push")
    recording = trundle.Recording(got.metadata, got.episodes)
    assert recording.metadata["split"]["held_out"] == ["exp_2"]
    poses = recording.episodes["exp_2"]["object_x"]
    assert np.sum(~np.isnan(poses)) == 493
    assert any("exp_2: 7 poses of a lost tracker omitted" in remark for remark in got.remarks)
    begin, end = recording.metadata["wrench"]["precontact"]["exp_1"]
    assert begin == 0.0
    assert end == pytest.approx(6.0, abs=0.05)
    theta = recording.episodes["exp_1"]["object_theta"]
    # Its x is the body's z, which this attitude lays along the world's -y.
    np.testing.assert_allclose(theta[~np.isnan(theta)], -np.pi / 2, atol=1e-6)


def test_logs_with_another_load_are_a_separate_recording(tmp_path: Path) -> None:
    for name in ("exp3_1", "exp3_2", "exp3_3"):
        write_log(tmp_path, name, 0)
    got = read(tmp_path, "cmu-planar-push")
    assert list(got.episodes) == ["exp3_3"]
    assert "exp3_1: omitted, another load or floor; list it in `logs` of a map" in got.remarks
    assert list(read(tmp_path, "cmu-planar-push", CONFIGS / "cmu_earlier.toml").episodes) == [
        "exp3_1",
        "exp3_2",
    ]


def test_logs_cannot_be_selected_for_pushes(tmp_path: Path) -> None:
    with pytest.raises(ValueError, match=r"`logs`: applies only to the folder timeseries/"):
        read(write_pushes(tmp_path / NAME), "cmu-planar-push", CONFIGS / "cmu_earlier.toml")


def test_a_missing_part_of_a_log_is_named(tmp_path: Path) -> None:
    write_log(tmp_path, "exp_1", 0)
    (tmp_path / "exp_1_pos.txt").unlink()
    with pytest.raises(ValueError, match=r"exp_1_pos\.txt: no such file; a log consists of NAME_force"):
        read(tmp_path, "cmu-planar-push")


def test_an_invalid_row_of_a_log_is_named(tmp_path: Path) -> None:
    write_log(tmp_path, "exp_1", 0)
    path = tmp_path / "exp_1_robot.txt"
    lines = path.read_text().splitlines()
    lines[3] = "500 0 15"
    path.write_text("\n".join(lines))
    with pytest.raises(ValueError, match=r"exp_1_robot\.txt: row 4 = '500 0 15': must contain 7 numbers"):
        read(tmp_path, "cmu-planar-push")


def held(table: Mapping[str, Floats], names: list[str], t: Floats) -> Floats:
    """Return a stream at the times t, interpolated linearly."""
    values = np.column_stack([table[name] for name in names])
    there = ~np.isnan(values).any(axis=1)
    return np.column_stack([np.interp(t, table["t"][there], column[there]) for column in values.T])


def force_on_object(table: Mapping[str, Floats], wrench: dict[str, Any], name: str, t: Floats) -> Floats:
    """Return the force on the object in world axes, N, (n, 2)."""
    begin, end = wrench["precontact"][name]
    reading = np.column_stack([table["force_x"], table["force_y"]])
    tare = np.nanmean(reading[(table["t"] >= begin) & (table["t"] <= end)], axis=0)
    sign = 1.0 if wrench["sign"] == "on_object" else -1.0
    force = sign * (held(table, ["force_x", "force_y"], t) - tare)
    theta = held({**table, "turn": unwrapped(table["gripper_theta"])}, ["turn"], t)[:, 0]
    c, s = np.cos(theta), np.sin(theta)
    return np.column_stack([c * force[:, 0] - s * force[:, 1], s * force[:, 0] + c * force[:, 1]])


def unwrapped(angle: Floats) -> Floats:
    there = ~np.isnan(angle)
    out = angle.copy()
    out[there] = np.unwrap(angle[there])
    return out


def smooth(values: Floats, span: int) -> Floats:
    return np.column_stack([np.convolve(column, np.ones(span) / span, mode="same") for column in values.T])


@pytest.mark.parametrize("surface", ["10_130_10_10_10_130", "30_63.33_43.33_30_43.33_63.33", "patch"])
def test_real_pushes_do_positive_work(real_data: RealData, surface: str) -> None:
    """Above 1 N, the force of the moving tip points along its motion."""
    source = real_data("cmu-planar-push/pushes") / f"hardboard__{surface}.txt"
    got = read(source, "cmu-planar-push")
    recording = trundle.Recording(got.metadata, got.episodes)
    assert len(recording.episodes) == 50
    positive = total = 0
    for name, table in recording.episodes.items():
        t = np.arange(0.2, table["t"][-1] - 0.2, 0.01)
        force = force_on_object(table, recording.metadata["wrench"], name, t)
        velocity = smooth(np.gradient(held(table, ["gripper_x", "gripper_y"], t), t, axis=0), 15)
        pushing = (np.hypot(*force.T) > 1.0) & (np.hypot(*velocity.T) > 1e-3)
        positive += int(np.sum((force * velocity).sum(axis=1)[pushing] > 0.0))
        total += int(np.sum(pushing))
    assert total > 15_000
    assert positive / total > 0.999


def test_real_tips_end_on_the_sides_of_the_triangle(real_data: RealData) -> None:
    """The object frame fits the footprint: after a push the tip is on one of its three sides."""
    got = read(real_data("cmu-planar-push/pushes") / "hardboard__patch.txt", "cmu-planar-push")
    distances = []
    for table in got.episodes.values():
        names = ["object_x", "object_y", "object_theta", "gripper_x", "gripper_y"]
        x, y, theta, tip_x, tip_y = (table[name][~np.isnan(table[name])][-1] for name in names)
        c, s = np.cos(theta), np.sin(theta)
        along, across = c * (tip_x - x) + s * (tip_y - y), c * (tip_y - y) - s * (tip_x - x)
        distances.append(min(abs(along), abs(across), abs(along + across - 0.15) / np.sqrt(2)))
    assert np.median(distances) < 1e-3
    assert np.max(distances) < 3e-3


@pytest.mark.parametrize(
    ("map_file", "logs", "held_out"),
    [
        (None, ["exp3_3", "exp3_4", "exp4_1"], "exp3_4"),
        (CONFIGS / "cmu_earlier.toml", ["exp3_1", "exp3_2"], "exp3_2"),
    ],
)
def test_real_logs_do_work_and_touch_the_inferred_sides(
    real_data: RealData, map_file: Path | None, logs: list[str], held_out: str
) -> None:
    """The force follows the motion of the contact point, and contacts are on the inferred outline."""
    got = read(real_data("cmu-planar-push/timeseries"), "cmu-planar-push", map_file)
    recording = trundle.Recording(got.metadata, got.episodes)
    assert list(recording.episodes) == logs
    assert recording.metadata["split"]["held_out"] == [held_out]
    corners = np.array(recording.metadata["object"]["footprint"])
    for name, table in recording.episodes.items():
        seen = ~np.isnan(table["object_x"])
        t = table["t"][seen]
        pose = held({**table, "turn": unwrapped(table["object_theta"])}, ["object_x", "object_y", "turn"], t)
        force = force_on_object(table, recording.metadata["wrench"], name, t)
        arm = held(table, ["gripper_x", "gripper_y"], t) - pose[:, :2]
        twist = smooth(np.gradient(pose, t, axis=0), 15)
        velocity = twist[:, :2] + twist[:, 2:] * np.column_stack([-arm[:, 1], arm[:, 0]])
        size, speed = np.hypot(*force.T), np.hypot(*velocity.T)
        # A lost body jumps by a radian, which is no sliding speed.
        sliding = (size > 0.1) & (speed > 1.5e-3) & (speed < 0.1)
        cosine = (force * velocity).sum(axis=1)[sliding] / (size * speed)[sliding]
        assert np.mean(cosine > 0.0) > 0.97, name
        assert np.mean(cosine) > 0.8, name
        touching = (size > 0.1) & (np.abs(twist[:, 2]) < 1.0)
        c, s = np.cos(pose[touching, 2]), np.sin(pose[touching, 2])
        x, y = arm[touching].T
        distance = outline_distance(corners, np.column_stack([c * x + s * y, c * y - s * x]))
        assert np.quantile(distance, 0.95) < 1.5e-3, name


def outline_distance(corners: Floats, points: Floats) -> Floats:
    """Return each point's distance to the polygon's outline, m."""
    distances = []
    for a, b in zip(corners, np.roll(corners, -1, axis=0), strict=True):
        along = np.clip((points - a) @ (b - a) / ((b - a) @ (b - a)), 0.0, 1.0)
        distances.append(np.linalg.norm(points - a - along[:, None] * (b - a), axis=1))
    return np.min(distances, axis=0)  # type: ignore[no-any-return]
