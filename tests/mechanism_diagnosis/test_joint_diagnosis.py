"""Diagnosis of recordings of joints: names, sizes, figures, files and refusals."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trundle
from tests.mechanism_diagnosis.recordings import (
    ARM,
    NOMINAL,
    arm_recording,
    log_of,
    pendulum_recording,
    write_log,
)
from trundle import _native
from trundle.cli import main
from trundle.joint_diagnosis import read_log
from trundle.joint_diagnosis.drives import late_command
from trundle.joint_diagnosis.mechanisms import load_mechanisms
from trundle.mechanism import MechanismModel, touching_bodies

FRICTION = 0.3
FILES = {"diagnosis.json", "model.toml", "predictions.parquet", "report.html"}


@pytest.fixture(scope="module")
def dry() -> trundle.JointDiagnosis:
    return trundle.diagnose(arm_recording(FRICTION))


def held_out(diagnosis: trundle.JointDiagnosis, side: str) -> dict[str, Any]:
    found: dict[str, Any] = diagnosis.answer["fit"]["held_out"][side]
    return found


def test_dry_friction_is_named_with_its_joint_and_size(dry: trundle.JointDiagnosis) -> None:
    assert (dry.verdict, dry.missing) == ("explained", ["joint_dry_friction:elbow"])
    (effect,) = dry.model.effect
    assert effect.parameters["effort"] == pytest.approx(FRICTION, rel=0.05)
    assert dry.model.mechanism.model == "robot.xml"
    assert "joint_dry_friction:elbow" in repr(dry)


def test_positions_of_held_out_episodes_improve(dry: trundle.JointDiagnosis) -> None:
    before, after = held_out(dry, "before"), held_out(dry, "after")
    for key in ("relative_position_rmse", "relative_window_rmse", "relative_effort_rmse"):
        assert after[key] < 0.5 * before[key]
    path = dry.predictions["e3"]
    assert path.before is not None and path.after is not None
    error = np.sqrt(np.mean((path.after - path.observed) ** 2, axis=0))
    assert error[1] == pytest.approx(after["joints"]["elbow"]["position_rmse"])


def test_nothing_is_missing_from_a_correct_model() -> None:
    diagnosis = trundle.diagnose(arm_recording(0.0))
    assert (diagnosis.verdict, diagnosis.missing) == ("consistent", [])
    assert held_out(diagnosis, "before")["relative_position_rmse"] < 0.01
    assert diagnosis.answer["residual"]["explained"] is None
    assert "of the misfit remains" not in diagnosis.report
    assert "The residual is within the noise." in diagnosis.report


def test_friction_of_a_free_pendulum_is_found_per_inertia() -> None:
    diagnosis = trundle.diagnose(pendulum_recording(0.15))
    assert diagnosis.missing == ["joint_dry_friction:arm"]
    effort = diagnosis.answer["missing"][0]["parameters"]["effort"]
    assert effort["mean"] == pytest.approx(0.15, rel=0.1)
    assert effort["unit"] == "rad/s²"


def test_written_files_are_readable_and_reproducible(dry: trundle.JointDiagnosis, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    folder = dry.write(tmp_path / "first")
    assert {file.name for file in folder.iterdir()} == FILES
    assert json.loads((folder / "diagnosis.json").read_text())["verdict"] == "explained"
    assert MechanismModel.read(folder / "model.toml") == dry.model
    table = parquet.read_table(folder / "predictions.parquet").to_pydict()
    assert list(table)[:6] == ["episode", "t", "scored"] + [
        f"{side}_q_shoulder" for side in ("observed", "before", "after")
    ]
    assert table["after_q_elbow"] == dry.predictions["e3"].after[:, 1].tolist()  # type: ignore[index]
    again = trundle.diagnose(arm_recording(FRICTION)).write(tmp_path / "second")
    for name in FILES:
        assert (folder / name).read_bytes() == (again / name).read_bytes()


def test_the_report_names_the_joint_and_draws_its_law(dry: trundle.JointDiagnosis) -> None:
    assert "dry friction at joint elbow" in dry.report
    for identity in ("mechanism-title", "law-elbow-speed-title", "held-out-e3-elbow-title"):
        assert f'id="{identity}"' in dry.report
    assert "--mjcf-patch" in dry.report


@pytest.fixture(scope="module")
def log(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder with a CSV log of 24 s and the arm's MJCF."""
    folder = tmp_path_factory.mktemp("log")
    truth = ARM.format(shoulder="", elbow=f' frictionloss="{FRICTION}"')
    write_log(folder / "log.csv", log_of(truth, 7, duration=24.0))
    (folder / "robot.xml").write_text(NOMINAL)
    return folder


def test_a_log_and_an_mjcf_file_are_diagnosed_in_one_line(
    log: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "out"
    command = [
        "diagnose",
        "--mjcf",
        str(log / "robot.xml"),
        str(log / "log.csv"),
        "--out",
        str(out),
        "--quiet",
    ]
    assert main(command) == 0
    printed = capsys.readouterr().out
    assert "joint_dry_friction:elbow (probability" in printed
    assert "columns:" not in printed
    assert {file.name for file in out.iterdir()} == FILES
    answer = json.loads((out / "diagnosis.json").read_text())
    assert "timing:elbow" in answer["nominal"]["after"]  # not a value of the mechanism
    patched = tmp_path / "patched"
    export = ["export", str(out / "model.toml"), "--mjcf-patch", str(patched)]
    assert main([*export, "--mjcf", str(log / "robot.xml")]) == 0
    assert "frictionloss" in (patched / "robot.xml").read_text()


def rename(old: str, new: str) -> Callable[[str], str]:
    return lambda text: text.replace(old, new)


def inserted(row: str) -> Callable[[str], str]:
    """Return a change that inserts a row as the third sample."""
    return lambda text: "\n".join([*text.split("\n")[:3], row, *text.split("\n")[3:]])


def in_degrees(text: str) -> str:
    """Return the log with the positions of the elbow in degrees."""
    head, *lines = text.splitlines()
    column = head.split(",").index("q_elbow")
    rows = [line.split(",") for line in lines]
    for row in rows:
        row[column] = str(np.degrees(float(row[column])))
    return "\n".join([head, *(",".join(row) for row in rows)]) + "\n"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (rename("elbow", "elbo"), "column q_elbo: a position of no joint"),
        (rename("q_elbow", "elbow_error"), "there is no position of joint elbow"),
        (rename("t,", "x,"), "no column of times"),
        (rename("effort_", "efort_"), "not known which quantity of joint"),
        (inserted("x,0,0,0,0"), "row 3, column 't': 'x' is not a number"),
        (inserted("1,2"), "row 3 has 2 cells and the header 5"),
        (lambda text: "", "is empty"),
        (in_degrees, "degrees"),
    ],
    ids=["joint", "column", "time", "positions", "number", "cells", "empty", "degrees"],
)
def test_bad_logs_are_refused(log: Path, tmp_path: Path, change: Callable[[str], str], message: str) -> None:
    path = tmp_path / "bad.csv"
    path.write_text(change((log / "log.csv").read_text()))
    with pytest.raises(trundle.TrundleError, match=message.replace("(", r"\(").replace("`", ".")):
        trundle.diagnose(path, mjcf=log / "robot.xml")


def with_effort(**settings: Any) -> trundle.JointRecording:
    recording = arm_recording(0.0)
    metadata = {**recording.metadata, "effort": settings}
    return trundle.JointRecording(metadata, recording, recording.files)


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"source": "measured", "signed": False}, "declared as a magnitude"),
        ({"source": "current"}, "gain"),
    ],
    ids=["unsigned", "no gain"],
)
def test_efforts_without_sign_or_gain_are_refused(settings: dict[str, Any], message: str) -> None:
    with pytest.raises(trundle.TrundleError, match=message):
        trundle.diagnose(with_effort(**settings))


def test_a_model_without_the_joints_is_refused(tmp_path: Path) -> None:
    other = tmp_path / "other.xml"
    other.write_text(NOMINAL.replace("elbow", "knee"))
    with pytest.raises(trundle.TrundleError, match="unknown joint 'elbow'"):
        trundle.diagnose(arm_recording(0.0), mjcf=other)


def test_an_axis_takes_no_model(tmp_path: Path) -> None:
    with pytest.raises(trundle.TrundleError, match="has an axis without a model"):
        trundle.diagnose(pendulum_recording(0.0), mjcf=tmp_path / "robot.xml")


def test_a_planar_recording_takes_no_model() -> None:
    with pytest.raises(trundle.TrundleError, match="`mjcf` is for recordings of joints"):
        trundle.diagnose(trundle.demo(), mjcf="robot.xml")


def test_an_unknown_effect_to_exclude_is_refused() -> None:
    with pytest.raises(trundle.TrundleError, match="did you mean `joint_dry_friction`"):
        trundle.diagnose(pendulum_recording(0.1), without=["joint_dry_frictoin"])


def test_the_last_quarter_of_a_log_is_held_out(log: Path) -> None:
    recording = read_log(log / "log.csv", log / "robot.xml")
    counts = [len(recording.frame(name)) for name in ("training", "held_out")]
    assert counts[0] == pytest.approx(3 * counts[1], rel=0.01)
    assert recording["held_out"].held_out
    assert not recording["training"].held_out


def test_contacts_that_the_recorded_efforts_contradict_are_ignored() -> None:
    recording = arm_recording(0.0)
    post = '<geom type="sphere" size="0.05" pos="0.25 0 0.45"/><body name="upper"'
    forearm = '<geom type="capsule" size="0.02" fromto="0 0 0 0 0 -0.3" mass="0"/><inertial pos="0 0 -0.15"'
    model = NOMINAL.replace('<body name="upper"', post).replace('<inertial pos="0 0 -0.15"', forearm)
    recording = trundle.JointRecording(recording.metadata, recording.episodes, {"robot.xml": model.encode()})
    motion = _native._joint_motion(recording)
    found = load_mechanisms(recording, motion)
    (warning,) = found.warnings
    assert "world and fore touch" in warning
    assert not any(touching_bodies(found.first, own["q"]) for own in motion["episodes"].values())


def test_held_out_episodes_do_not_decide_about_contacts(monkeypatch: pytest.MonkeyPatch) -> None:
    seen: list[int] = []

    def touching(_: object, q: np.ndarray) -> dict[tuple[str, str], float]:
        seen.append(len(q))
        return {}

    monkeypatch.setattr("trundle.mechanism.touching_bodies", touching)
    recording = arm_recording(FRICTION)
    load_mechanisms(recording, _native._joint_motion(recording))
    assert len(seen) == sum(not episode.held_out for episode in recording.values())


def test_a_simulated_drive_is_late_by_its_delay_and_lag() -> None:
    t = np.arange(0.0, 5.0, 0.01)
    command = np.sin(2.0 * t)
    late = late_command(command, {"drive_delay": {"delay": 0.05}}, 0.01)
    np.testing.assert_allclose(late[20:], np.sin(2.0 * (t[20:] - 0.05)), atol=1e-3)
    lagging = late_command(command, {"drive_lag": {"time_constant": 0.1}}, 0.01)
    expected = np.sin(2.0 * t - np.arctan(0.2)) / np.hypot(1.0, 0.2)
    np.testing.assert_allclose(lagging[200:], expected[200:], atol=2e-3)
    early = late_command(command, {"effort_delay": {"delay": 0.05}}, 0.01)
    np.testing.assert_allclose(early[:-20], np.sin(2.0 * (t[:-20] + 0.05)), atol=1e-3)
