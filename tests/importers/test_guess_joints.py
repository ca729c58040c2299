"""Maps of logs of joints, guessed from the names of their columns."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import trundle
from trundle.importers import guess_map, write_map
from trundle.importers.guess.joint_names import parse_joint_name
from trundle.importers.guess.joints import JointGuess, guess_joint_map
from trundle.importers.guess.table import read_table
from trundle.importers.layout import SourceError

JOINTS = ["shoulder", "wrist", "wrist_roll", "joint1"]
ARM = """<mujoco><worldbody>
<body><joint name="shoulder"/><geom type="capsule" fromto="0 0 0 .3 0 0" size=".02"/>
<body pos=".3 0 0"><joint name="elbow"/><geom type="capsule" fromto="0 0 0 .3 0 0" size=".02"/></body></body>
</worldbody></mujoco>"""


@pytest.mark.parametrize(
    ("text", "kind", "joint", "unit"),
    [
        ("q_shoulder", "q", "shoulder", None),
        ("shoulder.pos", "q", "shoulder", None),
        ("shoulder", "q", "shoulder", None),
        ("observation.state.shoulder.pos", "q", "shoulder", None),
        ("action.shoulder.pos", "target", "shoulder", None),
        ("wrist_deg", "q", "wrist", "deg"),
        ("Shoulder Position [deg]", "q", "shoulder", "deg"),
        ("wrist_roll_vel_rad_s", "v", "wrist_roll", "rad/s"),
        ("wrist_torque_Nm", "effort", "wrist", "N m"),
        ("tau_joint1", "effort", "joint1", None),
        ("target_joint1", "target", "joint1", None),
        ("on_wrist", "on", "wrist", None),
        ("temperature_wrist", None, "wrist", None),
        ("wrist_position_error", None, "wrist", None),
        ("cmd_velocity_wrist", None, "wrist", None),
        ("gripper", None, None, None),
        ("wrist_torque_mm", None, "wrist", "mm"),
        ("wrist torque (kgf cm)", None, "wrist", None),
    ],
)
def test_names_of_columns(text: str, kind: str | None, joint: str | None, unit: str | None) -> None:
    found = parse_joint_name(text, JOINTS)
    assert (found.kind, found.joint, found.unit) == (kind, joint, unit)


@pytest.mark.parametrize("joint", ["关节", "temp", "j.1/a", "_"])
def test_names_of_a_recording_are_exact(joint: str) -> None:
    for kind in ("q", "effort", "target"):
        found = parse_joint_name(f"{kind}_{joint}", ["other", joint])
        assert (found.kind, found.joint) == (kind, joint)
    assert parse_joint_name("battery", [joint]).joint is None


def test_commanded_efforts_and_currents_are_marked() -> None:
    assert parse_joint_name("effort_cmd_wrist", JOINTS).commanded
    assert parse_joint_name("motor_current_wrist", JOINTS).is_current
    assert parse_joint_name("wrist effort [mA]", JOINTS).is_current
    assert parse_joint_name("actual_q_3", JOINTS).index == 3


def guess(path: Path, header: str, joints: list[str] | None = None) -> JointGuess:
    """Return the guess of a log with this header and rows of numbers 10 ms apart."""
    names = header.split(",")
    rows = [",".join([f"{0.01 * k:.2f}", *["0.5"] * (len(names) - 1)]) for k in range(8)]
    path.write_text("\n".join([header, *rows]) + "\n")
    return guess_joint_map(path, read_table(path), ["shoulder", "elbow"] if joints is None else joints)


@pytest.mark.parametrize(
    ("header", "expected"),
    [
        (
            "t,q_shoulder,q_elbow,effort_shoulder",
            {"q_shoulder": "q_shoulder", "q_elbow": "q_elbow", "effort_shoulder": "effort_shoulder"},
        ),
        (
            "time,pos_0,pos_1,tau_1,tau_2",
            {"q_shoulder": "pos_0", "q_elbow": "pos_1", "effort_shoulder": "tau_1", "effort_elbow": "tau_2"},
        ),
        ("time,elbow,battery,note_shoulder", {"q_elbow": "elbow"}),
        (
            "time,elbow_pos,elbow_torque_cmd,elbow_torque,elbow_current",
            {"q_elbow": "elbow_pos", "effort_elbow": "elbow_torque"},
        ),
        ("time,elbow_pos,elbow_ref,elbow_temp", {"q_elbow": "elbow_pos", "target_elbow": "elbow_ref"}),
    ],
    ids=["format", "numbers", "plain name", "measured effort", "target"],
)
def test_streams(tmp_path: Path, header: str, expected: dict[str, str]) -> None:
    found = guess(tmp_path / "log.csv", header).settings["columns"]
    assert {name: source["name"] for name, source in found.items()} == expected


@pytest.mark.parametrize(
    ("header", "message"),
    [
        ("stamp_a,pos,tau", "no column with a joint's position among"),
        ("time,pos_0,pos_1,pos_2", "3 numbers, but the model has the joints shoulder, elbow"),
        ("time,pos_0,pos_1,tau_0", "tau_0: 1 numbers"),
        ("time,elbow_pos,elbow_position", "q_elbow may be elbow_pos or elbow_position"),
        ("time,elbow_pos,elbow_current", "a current needs a gain"),
        ("time,elbow_pos,efort_elbow", "column efort_elbow: not known which quantity"),
        ("elbow_pos,elbow_torque", "no column of times"),
        ("time,elbow_pos,q_shouldr", "column q_shouldr: a position of no joint"),
        ("time,elbow_pos,effort_elbo", "column effort_elbo: an effort of no joint of the model; .* elbow"),
        ("time,elbow_pos,shoulder_torque", "there is no position of joint shoulder"),
        ("time,elbow_pos,elbow_torque [kgf cm]", "not known which quantity of joint elbow"),
    ],
)
def test_doubtful_names_are_refused(tmp_path: Path, header: str, message: str) -> None:
    with pytest.raises(SourceError, match=message):
        guess(tmp_path / "log.csv", header)


def test_a_commanded_effort_is_declared(tmp_path: Path) -> None:
    found = guess(tmp_path / "log.csv", "time,elbow_pos,elbow_torque_cmd,run")
    assert found.settings["recording"] == {"effort": {"source": {"elbow": "commanded"}}}
    assert found.settings["episode_column"] == "run"
    assert found.text == "t = time, q_elbow = elbow_pos, effort_elbow = elbow_torque_cmd, episodes by run"


def test_a_time_in_two_columns(tmp_path: Path) -> None:
    found = guess(tmp_path / "log.csv", "stamp.secs,stamp.nsecs,elbow_pos")
    assert found.text == "t = stamp.secs + stamp.nsecs in ns, q_elbow = elbow_pos; taken as not driven: elbow"


def test_a_guessed_map_imports_a_log(tmp_path: Path) -> None:
    pytest.importorskip("mujoco")
    (tmp_path / "robot.xml").write_text(ARM)
    t = np.arange(40) * 5
    rows = [f"{ms};{30 * np.sin(ms):.3f};{ms % 7};ep {ms // 100}".replace(".", ",") for ms in t]
    path = tmp_path / "log.csv"
    path.write_text("\n".join(["time_ms;elbow angle [deg];elbow torque [Nm];run", *rows]) + "\n")
    given = {"recording": {"mechanism": {"model": str(tmp_path / "robot.xml")}}}
    found = guess_map(path, given)
    assert found.is_complete
    by_guess = trundle.importers.read(path, "csv", found.settings).recording()
    by_file = trundle.importers.read(path, "csv", write_map(found, tmp_path / "map.toml")).recording()
    assert isinstance(by_guess, trundle.JointRecording)
    assert list(by_guess) == list(by_file) == ["ep 0", "ep 1"]
    _, positions = by_guess["ep 0"].stream("q", "elbow")
    np.testing.assert_allclose(positions, np.radians(np.round(30 * np.sin(t[:20]), 3)))
