"""CSV logs of joints: drives that are not recorded, and remedies that a log has."""

from __future__ import annotations

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import trundle
from tests.mechanism_diagnosis.recordings import NOMINAL, Floats, arm_recording, log_of, write_log
from trundle.cli import main


def logged(folder: Path, change: Callable[[dict[str, Floats]], None]) -> tuple[Path, Path]:
    """Write a log of the arm after a change, and its model; return their paths."""
    columns = log_of(NOMINAL, 7, duration=12.0)
    change(columns)
    write_log(folder / "log.csv", columns)
    (folder / "robot.xml").write_text(NOMINAL)
    return folder / "log.csv", folder / "robot.xml"


def without_efforts(*joints: str) -> Callable[[dict[str, Floats]], None]:
    def change(columns: dict[str, Floats]) -> None:
        for joint in joints:
            del columns[f"effort_{joint}"]

    return change


def test_a_log_without_any_drive_is_refused_with_a_remedy(tmp_path: Path) -> None:
    log, model = logged(tmp_path, without_efforts("shoulder", "elbow"))
    with pytest.raises(trundle.TrundleError, match="no column is an effort or a target") as caught:
        trundle.diagnose(log, mjcf=model)
    (command,) = re.findall(r"`trundle (import .*) --out DIR`", str(caught.value))
    folder = tmp_path / "recording"
    assert main([*command.split(), "--out", str(folder), "--quiet"]) == 0
    recording = trundle.read(folder)
    assert isinstance(recording, trundle.JointRecording)  # its joints are not driven, by statement
    (episode,) = recording.values()
    assert set(episode) == {"t", "q_shoulder", "q_elbow"}


def test_joints_without_a_drive_are_listed(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log, model = logged(tmp_path, without_efforts("elbow"))
    out = str(tmp_path / "out")
    assert main(["diagnose", str(log), "--mjcf", str(model), "--out", out, "--quiet"]) == 0
    printed = capsys.readouterr()
    assert "taken as not driven: elbow" in printed.out
    assert "warning: the log has no effort and no target of elbow" in printed.err


def reverse(columns: dict[str, Floats]) -> None:
    columns["effort_elbow"] = -columns["effort_elbow"]


def drop_signs(columns: dict[str, Floats]) -> None:
    for joint in ("shoulder", "elbow"):
        columns[f"effort_{joint}"] = np.abs(columns[f"effort_{joint}"])


@pytest.mark.parametrize("change", [reverse, drop_signs], ids=["reversed", "unsigned"])
def test_remedies_of_a_log_are_commands_that_work(
    tmp_path: Path, change: Callable[[dict[str, Floats]], None]
) -> None:
    log, model = logged(tmp_path, change)
    with pytest.raises(trundle.TrundleError, match=r"a CSV log has no \[effort\] table") as caught:
        trundle.diagnose(log, mjcf=model)
    (command,) = re.findall(r"`trundle (import .*) --out DIR`", str(caught.value))
    for number, key in enumerate(re.findall(r"`(--set [^`]*)`", str(caught.value))):
        folder = tmp_path / f"recording_{number}"
        assert main([*command.split(), *key.split(), "--out", str(folder), "--quiet"]) == 0
        recording = trundle.read(folder)
        assert isinstance(recording, trundle.JointRecording)
        assert recording.metadata["effort"] in ({"gain": {"shoulder": -1.0}}, {"signed": False})


def test_a_free_joint_without_a_name_is_refused_in_words(tmp_path: Path) -> None:
    log, model = logged(tmp_path, lambda columns: None)
    base = '<worldbody><body name="trunk" pos="0 0 1"><freejoint/><geom size="0.1" mass="5"/>'
    text = NOMINAL.replace("<worldbody>", base).replace("</worldbody>", "</body></worldbody>")
    model.write_text(text)
    with pytest.raises(trundle.TrundleError, match="body 'trunk': its joint without a name is a free joint"):
        trundle.diagnose(log, mjcf=model)


@pytest.mark.parametrize("with_model", [True, False])
def test_check_reads_a_log(tmp_path: Path, capsys: pytest.CaptureFixture[str], *, with_model: bool) -> None:
    log, model = logged(tmp_path, reverse)
    named = ["--mjcf", str(model)] if with_model else []
    assert main(["check", str(log), *named, "--strict"]) == 2
    assert "effort of elbow" in capsys.readouterr().out
    (finding,) = trundle.check(log, mjcf=model if with_model else None).errors
    assert finding.kind == "sign"


def test_check_refuses_a_model_of_a_recording_and_a_log_of_other_joints(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    log, model = logged(tmp_path, lambda _: None)
    recording = arm_recording(0.0)
    with pytest.raises(trundle.TrundleError, match="mjcf: applies to CSV logs only"):
        trundle.check(recording, mjcf=model)
    other = tmp_path / "other.xml"
    other.write_text(NOMINAL.replace('"elbow"', '"knee"'))
    assert main(["check", str(log), "--mjcf", str(other)]) == 2
    assert "knee" in capsys.readouterr().err
