"""Designs for mechanisms: the trajectory or the change of load that separates two explanations."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trundle
from tests.joint_design.recordings import axis_recording, bench_recording
from trundle import _native
from trundle.cli import main
from trundle.joint_design import AxisLoad, JointDesign
from trundle.mechanism import MechanismModel, Payload

HORIZONTAL = np.pi / 2
DRY, LOAD = "joint_dry_friction:arm", "joint_load_friction:arm"


@pytest.fixture(scope="module")
def narrow() -> trundle.JointRecording:
    """Return motion about the horizontal, where gravity loads the axis evenly."""
    return axis_recording(HORIZONTAL, 0.1, noise=0.05)


@pytest.fixture(scope="module")
def one_load(narrow: trundle.JointRecording) -> JointDesign:
    return trundle.design(DRY, LOAD, recording=narrow)


def test_one_load_cannot_tell_dry_friction_from_load_friction(one_load: JointDesign) -> None:
    assert not one_load.rig_can_tell
    assert one_load.change is not None and min(one_load.separation) > one_load.threshold
    assert one_load.trajectories[0].change == one_load.change
    assert one_load.threshold == pytest.approx(np.log(0.95 / 0.05))
    assert "on this rig" in one_load.sentence and one_load.change in one_load.sentence


def test_a_wide_range_tells_dry_friction_from_load_friction() -> None:
    design = trundle.design(DRY, LOAD, recording=axis_recording(0.0, 1.2))
    assert design.rig_can_tell and design.change is None
    assert min(design.separation) > design.threshold
    assert design.models == (DRY, LOAD)


def test_trajectories_respect_the_limits(narrow: trundle.JointRecording) -> None:
    design = trundle.design(
        DRY,
        LOAD,
        recording=narrow,
        duration=5.0,
        position={"arm": (-0.5, 1.0)},
        speed=1.0,
        acceleration={"arm": 8.0},
        effort=0.7,
    )
    assert design.rig_can_tell
    for one in design.trajectories:
        assert one.t[-1] <= 5.02
        assert one.q.min() >= -0.5 and one.q.max() <= 1.0
        assert np.abs(one.v).max() <= 1.0
        assert np.abs(np.diff(one.v, axis=0)).max() <= 8.0 * 1.01 * (one.t[1] - one.t[0])
        assert one.effort["arm"] <= 0.71
        assert np.abs(one.v[[0, -1]]).max() < 1e-9


def test_own_loads_are_compared(narrow: trundle.JointRecording) -> None:
    light, heavy = AxisLoad(gravity_torque=0.005), AxisLoad(gravity_torque=0.5, inertia=0.005)
    assert trundle.design(DRY, LOAD, recording=narrow, loads=[light]).change is None
    design = trundle.design(DRY, LOAD, recording=narrow, loads=[light, heavy])
    assert design.change == "with an added load (gravity torque 0.5, inertia 0.005)"
    assert json.loads(design.to_json())["changes_tried"] == [
        "with an added load (gravity torque 0.005)",
        design.change,
    ]


def test_models_that_predict_the_same_are_reported_as_such(narrow: trundle.JointRecording) -> None:
    # A bias of the effort and a difference of dry friction by direction differ only with the load's sign.
    design = trundle.design(
        "effort_bias:arm", "joint_directional_friction:arm", recording=narrow, loads=[AxisLoad(inertia=1e-4)]
    )
    assert not design.rig_can_tell and design.change is None
    assert "Nor does it" in design.sentence and "The catalogue advises" in design.sentence


def test_the_unit_of_the_recorded_effort_does_not_matter() -> None:
    designs = [
        trundle.design(DRY, LOAD, recording=axis_recording(0.3, 0.8, gain=gain)) for gain in (1.0, 1e-3)
    ]
    first, second = (json.loads(design.to_json()) for design in designs)
    assert first["sentence"] == second["sentence"]
    np.testing.assert_allclose(first["separation"], second["separation"], rtol=1e-3)
    assert first["noise"]["arm"] == pytest.approx(second["noise"]["arm"], rel=1e-3)


def evidence(recording: trundle.JointRecording, names: tuple[str, str]) -> float:
    """Return the log-likelihood ratio of a recording in favour of the first effect."""
    from trundle.joint_diagnosis.mechanisms import load_mechanisms

    motion = _native._joint_motion(recording)
    dynamics = load_mechanisms(recording, motion).dynamics(motion, lambda _stage, _share: None)
    first, second = names
    return _native._joint_designer(recording, dynamics, [(first, {})], [(second, {})]).recorded


def test_a_designed_trajectory_separates_viscous_from_dry_friction_in_mujoco() -> None:
    names = ("joint_dry_friction:hinge", "joint_viscous_friction:hinge")
    friction = {"friction": 0.008, "damping": 0.0}
    viscous = {"friction": 0.0, "damping": 0.032}  # the same effort at the recorded speed of 0.25 rad/s
    for side, truth in enumerate((friction, viscous)):
        recording = bench_recording(truth["friction"], truth["damping"])
        design = trundle.design(*names, recording=recording)
        best = design.trajectories[0]
        repeated = bench_recording(truth["friction"], truth["damping"], (best.t, best.q[:, 0]))
        gain = (evidence(repeated, names) - evidence(recording, names)) * (1 if side == 0 else -1)
        assert design.rig_can_tell and gain > design.threshold
        assert 0.4 < gain / design.separation[side] < 2.5


def test_a_payload_is_a_change_of_load_for_a_model() -> None:
    recording = bench_recording(0.2, 0.0)
    names = ("joint_dry_friction:hinge", "joint_viscous_friction:hinge")
    design = trundle.design(*names, recording=recording, loads=[Payload("arm", 0.3, (0.1, 0.0, 0.0))])
    assert any(
        (one.change or "").startswith("with a payload of 0.3 kg on arm") for one in design.trajectories
    )


def test_model_files_are_explanations(
    narrow: trundle.JointRecording, one_load: JointDesign, tmp_path: Path
) -> None:
    for model, name in zip(one_load.fitted, ("a.toml", "b.toml"), strict=True):
        model.write(tmp_path / name)
    design = trundle.design(tmp_path / "a.toml", MechanismModel.read(tmp_path / "b.toml"), recording=narrow)
    assert design.models == one_load.models
    np.testing.assert_allclose(design.separation, one_load.separation, rtol=0.05)
    assert one_load.fitted[0].effect[0].parameters["effort"] == pytest.approx(0.08, rel=0.1)


def test_the_command_writes_the_same_design(
    narrow: trundle.JointRecording, one_load: JointDesign, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    narrow.write(tmp_path / "bench")
    folder = tmp_path / "out"
    assert (
        main(["design", DRY, LOAD, "--object", str(tmp_path / "bench"), "--out", str(folder), "--quiet"]) == 0
    )
    assert one_load.sentence in capsys.readouterr().out
    assert json.loads((folder / "design.json").read_text()) == json.loads(one_load.to_json())
    with (folder / "trajectory.csv").open() as stream:
        rows = list(csv.DictReader(stream))
    assert list(rows[0]) == ["t", "q_arm"]
    np.testing.assert_allclose(
        [float(row["q_arm"]) for row in rows], one_load.trajectories[0].q[:, 0], atol=1e-7
    )


def test_cards_show_the_result(one_load: JointDesign) -> None:
    assert one_load.sentence.split(":")[0][:40] in repr(one_load)
    assert "nats" in repr(one_load.trajectories[0])


@pytest.mark.parametrize(
    ("models", "options", "message"),
    [
        (("joint_rust:arm", LOAD), {}, "joint_rust:arm is unknown.*effects are .*joint_dry_friction:arm"),
        ((DRY, DRY), {}, "both explanations have the same effects"),
        ((DRY, f"{LOAD} + "), {}, "effects joined by"),
        ((DRY, "missing.toml"), {}, "missing.toml: no such file"),
        ((DRY, LOAD), {"speed": -1.0}, r"speed: arm = -1.0: a limit must be positive"),
        (
            (DRY, LOAD),
            {"effort": {"elbow": 1.0}},
            "effort: unknown joint 'elbow'; the recorded joints are arm",
        ),
        ((DRY, LOAD), {"position": {"arm": (1.0, 0.0)}}, "give a lower and a higher position"),
        ((DRY, LOAD), {"duration": 0.0}, "duration = 0.0: must be positive"),
        ((DRY, LOAD), {"pushes": 2}, "pushes = 2: bench is a recording of joints"),
        ((DRY, LOAD), {"loads": [Payload("arm", 1.0)]}, "give an AxisLoad"),
        ((DRY, LOAD), {"loads": [AxisLoad()]}, "at least one finite value"),
    ],
)
def test_wrong_arguments_are_refused(
    narrow: trundle.JointRecording, models: tuple[str, str], options: dict[str, Any], message: str
) -> None:
    with pytest.raises(trundle.TrundleError, match=message):
        trundle.design(*models, recording=narrow, **options)


def test_a_model_of_other_joints_is_refused(narrow: trundle.JointRecording) -> None:
    text = 'format = "trundle-model/2"\n[mechanism]\naxis = "hinge"\njoints = ["elbow"]\n'
    model = MechanismModel.from_toml(text)
    with pytest.raises(
        trundle.TrundleError, match="the model has the joints elbow, the recording bench has arm"
    ):
        trundle.design(model, DRY, recording=narrow)


def test_a_joint_without_a_drive_is_refused() -> None:
    t = np.arange(0, 8, 0.01)
    columns = {"t": t, "q_arm": np.exp(-0.1 * t) * np.sin(5 * t)}
    metadata = {
        "format": "trundle-recording/2",
        "name": "pendulum",
        "mechanism": {"axis": "hinge", "joints": ["arm"], "gravity": True},
    }
    recording = trundle.JointRecording(metadata, {"one": columns})
    with pytest.raises(trundle.TrundleError, match="joint arm has no drive"):
        trundle.design(DRY, "air_drag:arm", recording=recording)


def test_options_of_joints_are_refused_for_pushed_objects(tmp_path: Path) -> None:
    with pytest.raises(trundle.TrundleError, match=r"effort = 1\.0: these are models of a pushed object"):
        trundle.design(tmp_path / "a.toml", tmp_path / "b.toml", effort=1.0)  # type: ignore[call-overload]
