"""`trundle import` of joints on the command line, with the example maps."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trundle
from tests.importers import test_emps, test_lerobot, test_xl330
from tests.importers.joint_bags import NUMBERS, array, at, states, write_joint_bag
from trundle.cli import main

MAPS = Path(__file__).parents[2] / "configs" / "import"
ROBOT = (
    '<mujoco><worldbody><body name="upper"><joint name="shoulder"/><geom size="0.1"/><body name="lower">'
    '<joint name="elbow"/><geom size="0.1"/></body></body></worldbody></mujoco>'
)
pytestmark = pytest.mark.skipif(
    not hasattr(trundle, "JointRecording"), reason="the compiled module has no recordings of joints"
)


def example(name: str, tmp_path: Path) -> str:
    """Copy an example map next to a model."""
    (tmp_path / "robot.xml").write_text(ROBOT)
    (tmp_path / name).write_text((MAPS / name).read_text())
    return str(tmp_path / name)


@pytest.mark.parametrize("table", ["csv", "parquet"])
def test_a_bag_with_the_example_map(tmp_path: Path, table: str, capsys: pytest.CaptureFixture[str]) -> None:
    said = [("/arm_controller/commands", NUMBERS, at(0.1), array([0.3, 0.2]))]
    bag = write_joint_bag(tmp_path / "run_3", states() + said)
    out = tmp_path / "arm"
    arguments = ["--map", example("joint_states.toml", tmp_path), "--out", str(out), "--table", table]
    assert main(["import", str(bag), "--from", "mcap", *arguments]) == 0
    assert f"{out}: 1 episode, 50 rows" in capsys.readouterr().out
    recording: Any = trundle.read(out)
    assert recording.joints == ["shoulder", "elbow"]
    assert (out / "robot.xml").read_text() == ROBOT
    target = np.asarray(recording["episode_00"]["target_shoulder"])
    np.testing.assert_array_equal(target[np.isfinite(target)], [0.2])


def test_csv_files_with_the_example_map(tmp_path: Path) -> None:
    for run in ("run_1", "run_2", "run_3"):
        folder = tmp_path / "runs" / run
        folder.mkdir(parents=True)
        rows = [f'{k}000,"[0, {k}, 9]","[0, 1, 2]",{k}' for k in range(30)]
        (folder / "state.csv").write_text("a\nb\nc\nstamp,positions,velocities,i_2\n" + "\n".join(rows))
        (folder / "command.csv").write_text('stamp,positions\n0,"[0, 90, 180]"\n5500,"[0, 45, 90]"\n')
    arguments = ["--map", example("joints_csv.toml", tmp_path), "--out", str(tmp_path / "arm")]
    assert main(["import", str(tmp_path / "runs"), "--from", "csv", *arguments]) == 0
    recording = trundle.read(tmp_path / "arm")
    assert list(recording) == ["run_1", "run_2", "run_3"]
    target = np.asarray(recording["run_2"]["target_elbow"])
    np.testing.assert_allclose(target[np.isfinite(target)], [np.pi, np.pi / 2])
    assert recording["run_2"]["effort_elbow"][-1] == -29.0


def test_a_lerobot_data_set_with_the_example_map(tmp_path: Path) -> None:
    names = {"names": ["elbow_flex.pos", "lift.pos", "gripper.pos"]}
    source = test_lerobot.write(tmp_path / "pick", features={"observation.state": names, "action": names})
    arguments = ["--map", str(MAPS / "lerobot.toml"), "--out", str(tmp_path / "out")]
    assert main(["import", str(source), "--from", "lerobot", *arguments]) == 0
    assert len(trundle.read(tmp_path / "out")) == 4


def test_keys_on_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    test_emps.write(tmp_path)
    arguments = ["import", str(tmp_path), "--from", "emps", "--out", str(tmp_path / "out"), "--set"]
    assert main([*arguments, "format=2"]) == 0
    recording: Any = trundle.read(tmp_path / "out")
    assert recording.joints == ["load"]
    assert main([*arguments, "form=2"]) == 2
    assert "map: unknown key `form`; did you mean `format`?" in capsys.readouterr().err
    assert main([*arguments, "format=2", "--map", str(MAPS / "mat.toml")]) == 2
    assert "--set: applies only without --map" in capsys.readouterr().err


def test_an_invalid_recording_names_the_source(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log = test_xl330.write(tmp_path / "log.json")
    out = tmp_path / "out"
    arguments = ["--from", "xl330", "--set", "recording.effort.source=guessed", "--out", str(out)]
    assert main(["import", str(log), *arguments]) == 2
    said = capsys.readouterr().err
    assert "log.json: not a valid recording" in said and "guessed" in said
    assert not out.exists()
