"""`trundle.Record`: any episode as a recording."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import gymnasium
import numpy as np
import pytest
from numpy.typing import NDArray

import trundle

ID = "trundle/LockedWheel-v0"
Env = gymnasium.Env[NDArray[np.float64], NDArray[np.float32]]


def push(env: Env, steps: int, seed: int) -> int:
    """Push with actions of 0.4 s, and return the number of steps until the end."""
    random = np.random.default_rng(seed)
    action = np.zeros(3, dtype=np.float32)
    for k in range(steps):
        if k % 8 == 0:
            action = random.uniform(-0.4, 0.4, 3).astype(np.float32)
        if env.step(action)[2]:
            return k + 1
    return steps


@pytest.mark.parametrize("table", ["csv", "parquet"])
def test_several_episodes_of_one_object_are_one_recording(
    tmp_path: Path, table: Literal["csv", "parquet"]
) -> None:
    env = trundle.Record(gymnasium.make(ID), tmp_path / "pushes", table=table, held_out=1)
    lengths = []
    for episode in range(3):
        env.reset(seed=4 if episode == 0 else None)
        lengths.append(push(env, 40, episode))
    env.close()
    assert env.folders == [tmp_path / "pushes"]
    recording = trundle.read(tmp_path / "pushes")
    assert recording.name == "pushes"
    assert recording.metadata["split"]["held_out"] == ["episode_02"]
    assert list(tmp_path.joinpath("pushes").glob(f"*.{table}")) and len(recording.episodes) == 3
    for steps, columns in zip(lengths, recording.episodes.values(), strict=True):
        assert columns["t"][0] == 0.0
        assert columns["t"][-1] == pytest.approx(0.4 + 0.05 * steps, abs=0.01)
        assert np.isfinite(columns["force_x"]).sum() == pytest.approx(200 * (0.4 + 0.05 * steps), abs=1)
        assert np.isfinite(columns["object_x"]).sum() == pytest.approx(60 * (0.4 + 0.05 * steps), abs=1)
    trundle.inspect(recording)
    trundle.check(recording)


def test_recording_does_not_change_the_episode(tmp_path: Path) -> None:
    plain: Env = gymnasium.make(ID)
    recorded: Env = trundle.Record(gymnasium.make(ID), tmp_path / "r")
    action = np.array([0.2, 0.1, 0.1], dtype=np.float32)
    np.testing.assert_array_equal(plain.reset(seed=1)[0], recorded.reset(seed=1)[0])
    for _ in range(20):
        np.testing.assert_array_equal(plain.step(action)[0], recorded.step(action)[0])


def test_the_sensor_reads_the_wrench_in_its_own_frame(tmp_path: Path) -> None:
    env: Env = trundle.Record(gymnasium.make(ID, noise=0.0), tmp_path / "r")
    env.reset(seed=1, options={"start": (0.3, -0.1, 0.7), "grasp": (-0.5, 0.2)})
    action = np.array([0.3, -0.2, 0.1], dtype=np.float32)
    for _ in range(10):
        env.step(action)
    env.close()
    columns = trundle.read(tmp_path / "r").episodes["episode_00"]
    reading = np.column_stack([columns[key] for key in ("force_x", "force_y", "torque_z")])
    reading = reading[np.isfinite(reading[:, 0])]
    np.testing.assert_allclose(reading[-1] - reading[0], action * np.array([100.0, 100.0, 40.0]), rtol=1e-6)
    first = {key: columns[key][0] for key in ("object_x", "object_y", "gripper_x", "gripper_y")}
    cos, sin = np.cos(0.7), np.sin(0.7)
    assert first["gripper_x"] - first["object_x"] == pytest.approx(-0.5 * cos - 0.2 * sin)
    assert first["gripper_y"] - first["object_y"] == pytest.approx(-0.5 * sin + 0.2 * cos)
    assert "noise" not in trundle.read(tmp_path / "r").metadata


def test_another_object_starts_another_recording(tmp_path: Path) -> None:
    env = trundle.Record(gymnasium.make(ID), tmp_path / "r")
    for seed in (1, None, 2):
        env.reset(seed=seed)
        push(env, 10, 0)
    env.close()
    assert env.folders == [tmp_path / "r", tmp_path / "r_2"]
    assert [len(trundle.read(folder).episodes) for folder in env.folders] == [2, 1]


def test_the_hidden_wheel_may_change(tmp_path: Path) -> None:
    env = trundle.Record(gymnasium.make(ID), tmp_path / "r", keep_object=False)
    for _ in range(2):
        env.reset()
        push(env, 10, 0)
    env.close()
    assert len(env.folders) == 2


def test_an_empty_episode_is_not_written(tmp_path: Path) -> None:
    env = trundle.Record(gymnasium.make(ID), tmp_path / "r")
    env.reset(seed=0)
    env.close()
    assert env.folders == [] and list(tmp_path.iterdir()) == []


def test_an_unrelated_folder_is_not_changed(tmp_path: Path) -> None:
    folder = tmp_path / "r"
    folder.mkdir()
    (folder / "thesis.tex").write_text("precious")
    env = trundle.Record(gymnasium.make(ID), folder)
    env.reset(seed=0)
    push(env, 5, 0)
    with pytest.raises(trundle.TrundleError, match="r"):
        env.close()
    assert [path.name for path in tmp_path.rglob("*")] == ["r", "thesis.tex"]


def test_only_environments_with_a_sensor_are_recorded(tmp_path: Path) -> None:
    other: Any = gymnasium.make("CartPole-v1")
    with pytest.raises(trundle.TrundleError, match="cannot be recorded"):
        trundle.Record(other, tmp_path / "r")
    with pytest.raises(trundle.TrundleError, match="parquet"):
        trundle.Record(gymnasium.make(ID), tmp_path / "r", table="xls")  # type: ignore[arg-type]


def test_every_recording_has_its_own_object_and_walls(tmp_path: Path) -> None:
    env = trundle.Record(gymnasium.make("trundle/PushDoor-v0", object="household"), tmp_path / "door")
    shown = []
    for seed in (1, 2):
        env.reset(seed=seed)
        push(env, 5, seed)
        seen: Any = env.unwrapped
        shown.append(seen.recording_metadata("x"))
    env.close()
    written = [trundle.read(folder).metadata for folder in env.folders]
    for key in ("object", "scene"):
        assert [metadata[key] for metadata in written] == [metadata[key] for metadata in shown]
        assert written[0][key] != written[1][key]


def test_a_fast_clock_loses_no_readings(tmp_path: Path) -> None:
    early = [{"kind": "latency", "delay": -0.1}]
    counts = []
    for name, effects in (("on_time", []), ("early", early)):
        made = gymnasium.make("trundle/PushPose-v0", effects=effects)
        env = trundle.Record(made, tmp_path / name)
        env.reset(seed=0)
        for _ in range(20):
            env.step(np.array([0.1, 0.0, 0.0], dtype=np.float32))
        env.close()
        counts.append(len(trundle.read(tmp_path / name).frame("episode_00")["force_x"].dropna()))
    assert counts[1] >= counts[0] - 0.11 * 260, counts


def test_a_recorded_environment_cannot_be_restored(tmp_path: Path) -> None:
    env = trundle.Record(gymnasium.make(ID), tmp_path / "pushes")
    env.reset(seed=0)
    task: Any = env.unwrapped
    with pytest.raises(trundle.TrundleError, match="recorded"):
        task.restore(task.snapshot())
    env.close()
