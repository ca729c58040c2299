"""Patched models move in plain MuJoCo as models with the same physics that are made by other means."""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from trundle import TrundleError
from trundle.cli import main
from trundle.export import write_mjcf_patch
from trundle.mechanism import (
    EffortDrive,
    JointEffect,
    Mechanism,
    MechanismModel,
    MechanismTable,
    PositionDrive,
    Posterior,
    simulate,
)
from trundle.mechanism.simulation import JointLaws
from trundle.settings import parse

Floats = NDArray[np.float64]

ROBOT = """<mujoco>
<compiler inertiafromgeom="true"/>
<option timestep="0.001" integrator="implicitfast"/>
<default><default class="arm"><joint axis="0 1 0" damping="0.2" armature="0.03"/></default></default>
<worldbody>
  <geom type="box" size="0.1 0.1 0.01" contype="0" conaffinity="0"/>
  <body name="upper">
    <joint name="shoulder" class="arm" range="-170 170" stiffness="2" springref="10"/>
    <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.03" mass="1.5" contype="0"/>
    <body name="lower" pos="0.3 0 0">
      <joint name="elbow" class="arm" ref="20"/>
      <geom type="capsule" fromto="0 0 0 0.25 0 0" size="0.02" mass="0.7" contype="0"/>
      <body name="tool" pos="0.25 0 0"><geom size="0.03" mass="0.2" contype="0"/></body>
    </body>
  </body>
</worldbody>
<actuator><motor name="upper_motor" joint="shoulder"/></actuator>
<keyframe><key qpos="0 0"/></keyframe>
</mujoco>"""
JOINTS = ["shoulder", "elbow"]
TIMES = np.linspace(0.0, 0.6, 601)
START = np.array([0.3, 0.5])


def control(t: float) -> Floats:
    return np.array([6.0 * math.sin(5 * t) - 4.0, 1.5 * math.sin(9 * t + 1)])


def model(*effects: JointEffect, **nominal: float) -> MechanismModel:
    values = {key.replace("__", ":"): value for key, value in nominal.items()}
    return MechanismModel(MechanismTable(JOINTS, "robot.xml"), values, list(effects))


def effect(kind: str, where: str | None = "elbow", **parameters: float) -> JointEffect:
    if kind == "payload":
        return JointEffect(kind, body=where, parameters=parameters)
    return JointEffect(kind, joint=where, parameters=parameters)


def patched(tmp_path: Path, described: MechanismModel, text: str = ROBOT) -> Path:
    (tmp_path / "source").mkdir(exist_ok=True)
    (tmp_path / "source" / "robot.xml").write_text(text)
    described.write(tmp_path / "source" / "model.toml")
    return write_mjcf_patch(tmp_path / "source" / "model.toml", tmp_path / "exports" / "patched")


def play(folder: Path, start: Floats = START, drive: Callable[[float], Floats] = control) -> Floats:
    """Simulate the patched model in plain MuJoCo and return the positions of shoulder and elbow."""
    compiled = mujoco.MjModel.from_xml_path(str(folder / "robot.xml"))
    data = mujoco.MjData(compiled)
    data.qpos[:2] = start
    by_control = {compiled.actuator(k).trnid[0]: k for k in range(compiled.nu)}
    out = [data.qpos[:2].copy()]
    if (folder / "effects.py").exists():
        spec = importlib.util.spec_from_file_location("effects", folder / "effects.py")
        assert spec is not None
        assert spec.loader is not None
        module: Any = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(module)
        mujoco.set_mjcb_passive(module.Effects(compiled).apply)
    try:
        for t in TIMES[:-1]:
            for k, value in enumerate(drive(t)):
                dof = compiled.joint(JOINTS[k]).dofadr[0]
                if dof in by_control:
                    data.ctrl[by_control[dof]] = value
                else:
                    data.qfrc_applied[dof] = value
            mujoco.mj_step(compiled, data)
            out.append(data.qpos[[compiled.joint(name).qposadr[0] for name in JOINTS]].copy())
    finally:
        mujoco.set_mjcb_passive(None)
    return np.array(out)


@cache
def nominal() -> Floats:
    """Simulate the original model."""
    return reference()


def reference(
    law: JointLaws | None = None,
    drive: Callable[[float], Floats] = control,
    start: Floats = START,
    text: str = ROBOT,
    change: Callable[[Mechanism], Mechanism] = lambda mechanism: mechanism,
) -> Floats:
    """Simulate the original model with a law written as a formula."""
    mechanism = change(Mechanism.load(text, JOINTS))
    efforts = EffortDrive(TIMES, [drive(t) for t in TIMES], hold=True)
    return simulate(mechanism, TIMES, start, np.zeros(2), efforts, law)[0]


def force(formula: Callable[[float, float], float]) -> JointLaws:
    """Return a law of an effort at the elbow by its position and velocity."""

    def law(t: float, q: Floats, v: Floats, load: Floats) -> tuple[Floats, Floats, Floats]:
        return np.array([0.0, formula(q[1], v[1])]), np.zeros(2), np.zeros(2)

    return law


def friction(formula: Callable[[float, float], float]) -> JointLaws:
    """Return a law of dry friction at the elbow by its velocity and load."""

    def law(t: float, q: Floats, v: Floats, load: Floats) -> tuple[Floats, Floats, Floats]:
        return np.zeros(2), np.array([0.0, formula(v[1], load[1])]), np.zeros(2)

    return law


CASES: dict[str, tuple[JointEffect, JointLaws]] = {
    "viscous": (effect("joint_viscous_friction", damping=0.5), force(lambda q, v: -0.5 * v)),
    "drag": (effect("air_drag", coefficient=0.2), force(lambda q, v: -0.2 * abs(v) * v)),
    "dry": (effect("joint_dry_friction", effort=0.6), friction(lambda v, load: 0.6)),
    "stribeck": (
        effect("joint_dry_friction", effort=0.3, static_effort=0.9, velocity=0.5),
        friction(lambda v, load: 0.3 + 0.6 * math.exp(-((v / 0.5) ** 2))),
    ),
    "load": (
        effect("joint_load_friction", coefficient=0.2),
        friction(lambda v, load: 0.2 * abs(load)),
    ),
    "direction": (
        effect("joint_directional_friction", viscous_difference=0.2, dry_difference=0.3),
        force(lambda q, v: -0.3 - 0.2 * abs(v)),
    ),
    "spring": (
        effect("joint_spring", stiffness=4.0, rest=0.2),
        force(lambda q, v: -4.0 * (q - 0.2)),
    ),
    "second spring": (
        effect("joint_spring", "shoulder", stiffness=4.0, rest=0.2),
        lambda t, q, v, load: (np.array([-4.0 * (q[0] - 0.2), 0.0]), np.zeros(2), np.zeros(2)),
    ),
    "upper stop": (
        effect("joint_stop", position=0.6, stiffness=80.0, side=1.0),
        force(lambda q, v: -80.0 * max(q - 0.6, 0.0)),
    ),
    "lower stop": (
        effect("joint_stop", position=0.3, stiffness=80.0, side=-1.0),
        force(lambda q, v: 80.0 * max(0.3 - q, 0.0)),
    ),
    "cogging": (
        effect("joint_cogging", period=0.3, amplitude=0.5, phase=0.4),
        force(lambda q, v: 0.5 * math.sin(2 * math.pi * q / 0.3 + 0.4)),
    ),
}


@pytest.mark.parametrize("case", CASES)
def test_effects_at_joints(case: str, tmp_path: Path) -> None:
    missing, law = CASES[case]
    found, expected, without = play(patched(tmp_path, model(missing))), reference(law), nominal()
    moved = np.abs(expected - without).max()
    assert moved > 0.03
    np.testing.assert_allclose(found, expected, atol=0.02 * moved + 2e-4)


def test_refitted_values_and_bodies(tmp_path: Path) -> None:
    described = model(
        effect("rotor_inertia", armature=0.02),
        effect("payload", "tool", mass=0.4, com_x=0.05, com_z=-0.02),
        effect("base_tilt", None, angle_x=0.2, angle_y=-0.3),
        damping__elbow=0.5,
        armature__elbow=0.05,
        mass__tool=1.3,
    )
    found = play(patched(tmp_path, described))
    grown = 1.3 / 0.9
    text = ROBOT.replace('mass="0.7"', f'mass="{0.7 * grown}"').replace('mass="0.2"', f'mass="{0.2 * grown}"')
    payload = '<body pos="0.05 0 -0.02"><geom size="1e-4" mass="0.4" contype="0"/></body></body>\n    </body>'

    def change(mechanism: Mechanism) -> Mechanism:
        other = mechanism.adjusted(damping={"elbow": 0.5}, armature={"elbow": 0.07})
        cx, sx, cy, sy = math.cos(0.2), math.sin(0.2), math.cos(-0.3), math.sin(-0.3)
        about_x, about_y = [[1, 0, 0], [0, cx, -sx], [0, sx, cx]], [[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]]
        other.compiled.opt.gravity[:] = np.array(about_y) @ np.array(about_x) @ [0, 0, -9.81]
        return other

    expected = reference(change=change, text=text.replace("</body>\n    </body>", payload))
    np.testing.assert_allclose(found, expected, atol=2e-4)


def lagged(time_constant: float) -> Callable[[float], Floats]:
    values, state = {}, 0.0
    for t in TIMES:
        values[t] = np.array([control(t)[0], state])
        state += (control(t)[1] - state) * (1 - math.exp(-0.001 / time_constant))
    return lambda t: values[t]


def elbow(formula: Callable[[float], float]) -> Callable[[float], Floats]:
    return lambda t: np.array([control(t)[0], formula(control(t)[1])])


DRIVES: dict[str, tuple[list[JointEffect], Callable[[float], Floats]]] = {
    "gain and bias": (
        [effect("effort_bias", bias=0.4), effect("effort_gain", gain=1.5)],
        elbow(lambda u: (u - 0.4) / 1.5),
    ),
    "delay": (
        [effect("drive_delay", delay=0.04)],
        lambda t: np.array([control(t)[0], control(t - 0.04)[1] if t >= 0.04 - 1e-9 else 0.0]),
    ),
    "lag": ([effect("drive_lag", time_constant=0.05)], lagged(0.05)),
    "saturation": ([effect("effort_saturation", limit=0.7)], elbow(lambda u: min(max(u, -0.7), 0.7))),
    "droop": (
        [effect("drive_gain_droop", droop=0.4, max_effort=1.5)],
        elbow(lambda u: u * (1 - 0.4 * abs(u) / 1.5)),
    ),
}


@pytest.mark.parametrize("case", DRIVES)
def test_effects_of_drives(case: str, tmp_path: Path) -> None:
    effects, drive = DRIVES[case]
    found, expected, without = play(patched(tmp_path, model(*effects))), reference(drive=drive), nominal()
    moved = np.abs(expected - without).max()
    assert moved > 0.01
    np.testing.assert_allclose(found, expected, atol=0.02 * moved + 2e-4)


@pytest.mark.parametrize("actuator", ["", '<position name="servo" joint="elbow" kp="3" gear="2"/>'])
def test_target_drives(actuator: str, tmp_path: Path) -> None:
    described = model(target_stiffness__elbow=30.0, target_damping__elbow=1.5, target_limit__elbow=4.0)
    text = ROBOT.replace("<actuator>", f"<actuator>{actuator}")

    def target(t: float) -> Floats:
        return np.array([0.0, 0.8 if t > 0.2 else 0.4])

    servo = PositionDrive(
        TIMES,
        [target(t) for t in TIMES],
        stiffness=[0.0, 30.0],
        damping=[0.0, 1.5],
        limit=[np.inf, 4.0],
    )
    expected = simulate(Mechanism.load(ROBOT, JOINTS), TIMES, START, np.zeros(2), servo)[0]
    np.testing.assert_allclose(play(patched(tmp_path, described, text), drive=target), expected, atol=2e-3)


def test_an_encoder_offset_shifts_positions_and_all_that_refers_to_them(tmp_path: Path) -> None:
    offset = 0.15
    described = model(
        effect("encoder_offset", "shoulder", offset=offset),
        effect("joint_stop", "shoulder", position=0.35, stiffness=200.0, side=1.0),
        effect("joint_cogging", "shoulder", period=0.2, amplitude=1.0, phase=0.4),
    )

    def law(t: float, q: Floats, v: Floats, load: Floats) -> tuple[Floats, Floats, Floats]:
        effort = math.sin(2 * math.pi * q[0] / 0.2 + 0.4) - 200.0 * max(q[0] - 0.35, 0.0)
        return np.array([effort, 0.0]), np.zeros(2), np.zeros(2)

    found = play(patched(tmp_path, described), START + np.array([offset, 0.0]))
    expected = reference(law)
    assert expected[:, 0].max() > 0.36
    np.testing.assert_allclose(found - np.array([offset, 0.0]), expected, atol=5e-3)
    compiled = mujoco.MjModel.from_xml_path(str(tmp_path / "exports" / "patched" / "robot.xml"))
    np.testing.assert_allclose(compiled.joint("shoulder").range, np.radians([-170, 170]) + offset, atol=1e-5)


def settled(folder: Path) -> tuple[Any, Any]:
    """Return model and state at rest without control, under strong damping."""
    compiled = mujoco.MjModel.from_xml_path(str(folder / "robot.xml"))
    data = mujoco.MjData(compiled)
    compiled.dof_damping[:] = np.maximum(compiled.dof_damping, 1.0)
    mujoco.mj_step(compiled, data, nstep=10_000)
    assert np.abs(data.qvel).max() < 1e-3
    return compiled, data


def test_elasticity_bends_under_the_transmitted_load(tmp_path: Path) -> None:
    described = model(
        effect("joint_elasticity", "shoulder", stiffness=50.0, damping=0.5),
        effect("joint_spring", "shoulder", stiffness=20.0, rest=0.3),
    )
    compiled, data = settled(patched(tmp_path, described))
    q = data.joint("shoulder").qpos[0] + data.joint("shoulder_compliance").qpos[0]
    bent = data.joint("shoulder_compliance").qpos[0]
    # At the output: gravity, the model's own spring and the added one, against the compliance.
    pose = np.array([[q, data.joint("elbow").qpos[0]]])
    needed = Mechanism.load(ROBOT, JOINTS).inverse_dynamics(pose, 0 * pose, 0 * pose)[0, 0]
    assert abs(bent) < 1e-3  # without a drive nothing is transmitted
    assert needed + 20.0 * (q - 0.3) == pytest.approx(0.0, abs=0.1)
    data.ctrl[0] = 5.0
    mujoco.mj_step(compiled, data, nstep=10_000)
    assert data.joint("shoulder_compliance").qpos[0] == pytest.approx(-5.0 / 50.0, rel=1e-3)


def test_backlash_opens_to_its_width(tmp_path: Path) -> None:
    described = model(effect("joint_backlash", "shoulder", gap=0.2))
    compiled, data = settled(patched(tmp_path, described))
    for sign in (1.0, -1.0):
        data.ctrl[0] = 3.0 * sign
        mujoco.mj_step(compiled, data, nstep=8000)
        assert data.joint("shoulder_play").qpos[0] == pytest.approx(-sign * 0.1, rel=0.02)
    # The limits of the model's joint act on the sum of drive and play.
    np.testing.assert_allclose(
        compiled.tendon_range[compiled.tendon("shoulder_range").id], np.radians([-170, 170]), atol=1e-5
    )
    assert not compiled.jnt_limited[compiled.joint("shoulder").id]
    assert compiled.nkey == 0
    assert (
        "the sum of shoulder and shoulder_play"
        in (tmp_path / "exports" / "patched" / "robot.xml").read_text()
    )


def test_ranges_respect_bounds(tmp_path: Path) -> None:
    described = model(effect("joint_dry_friction", effort=0.1), damping__elbow=0.5)
    names = ["damping:elbow", "joint_dry_friction:elbow.effort"]
    posterior = Posterior(names, [0.5, 0.1], [[0.01, 0.0], [0.0, 0.04]])
    described = MechanismModel(described.mechanism, described.nominal, described.effect, posterior)
    folder = patched(tmp_path, described)
    table = parse(folder / "randomisation.toml")
    assert [one["name"] for one in table["parameter"]] == names
    assert table["parameter"][0]["low"] == pytest.approx(0.5 - 1.96 * 0.1, abs=1e-4)
    assert (table["parameter"][1]["low"], table["parameter"][1]["sd"]) == (0.0, pytest.approx(0.2))
    assert MechanismModel.read(folder / "model.toml") == described
    assert sorted(path.name for path in folder.iterdir()) == ["model.toml", "randomisation.toml", "robot.xml"]


def test_files_of_the_original_are_found_from_the_new_folder(tmp_path: Path) -> None:
    mesh = '<asset><mesh name="part" file="part.obj"/><mesh name="gone" file="gone.obj"/></asset>'
    geoms = '<geom type="mesh" mesh="part" mass="0"/><geom type="mesh" mesh="gone" mass="0"/>'
    text = ROBOT.replace("<worldbody>", f"{mesh}<worldbody>{geoms}")
    (tmp_path / "source").mkdir()
    faces = "f 1 2 3\nf 1 3 4\nf 1 4 2\nf 2 4 3\n"
    (tmp_path / "source" / "part.obj").write_text(f"v 0.1 0 0\nv 0 0.1 0\nv 0 0 0.1\nv 0 0 0\n{faces}")
    folder = patched(tmp_path, model(), text)
    assert mujoco.MjModel.from_xml_path(str(folder / "robot.xml")).nmesh == 1
    assert "missing files are removed: gone.obj" in (folder / "robot.xml").read_text()


@pytest.mark.parametrize(
    ("described", "message"),
    [
        (
            model(effect("joint_dry_friction", "wrist", effort=1.0)),
            "unknown joint 'wrist'; the recorded joints are",
        ),
        (model(effect("joint_dry_friction")), "joint_dry_friction:elbow: `effort` is missing"),
        (model(effect("rust", amount=1.0)), "kind = 'rust': unknown; known are encoder_offset"),
        (model(mas__lower=1.0), "'mas:lower': unknown value; known are armature, damping, mass"),
        (model(effect("payload", "hand", mass=1.0)), "payload:hand: the model has no such body"),
        (
            model(effect("joint_backlash", gap=0.1), armature__elbow=0.0),
            "'elbow' has no armature, which is the inertia of the drive",
        ),
    ],
)
def test_refusals(described: MechanismModel, message: str, tmp_path: Path) -> None:
    with pytest.raises(TrundleError, match=message):
        patched(tmp_path, described)
    assert not (tmp_path / "exports").exists()


def test_an_axis_cannot_be_patched(tmp_path: Path) -> None:
    MechanismModel(MechanismTable(["arm"], axis="hinge")).write(tmp_path / "model.toml")
    with pytest.raises(TrundleError, match="an axis without an MJCF file cannot be patched"):
        write_mjcf_patch(tmp_path / "model.toml", tmp_path / "patched")


def test_the_command(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("robot.xml").write_text(ROBOT)
    Path("diagnosis").mkdir()
    described = model(effect("joint_dry_friction", effort=0.6), effect("effort_delay", delay=0.01))
    described.write("diagnosis/model.toml")
    line = ["export", "diagnosis/model.toml", "--mjcf-patch", "patched"]
    assert main(line) == 2
    assert "robot.xml: no such file; give the MJCF or URDF file with --mjcf FILE" in capsys.readouterr().err
    assert main([*line, "--mjcf", "robot.xml"]) == 0
    names = ("model.toml", "randomisation.toml", "robot.xml")
    assert capsys.readouterr().out.split() == [f"patched/{name}" for name in names]
    assert "effort_delay:elbow is a property of the recorded effort" in Path("patched/robot.xml").read_text()
    for arguments, message in (
        (["--mujoco", "--mjcf", "robot.xml"], "--mjcf robot.xml: applies only to --mjcf-patch"),
        (["--mjcf-patch", "other", "--out", "more"], "--mjcf-patch other: --out and --footprint apply only"),
    ):
        assert main(["export", "diagnosis/model.toml", *arguments]) == 2
        assert message in capsys.readouterr().err
