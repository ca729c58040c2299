"""Patched models move in plain MuJoCo as models with the same physics that are made by other means."""

from __future__ import annotations

import importlib.util
import math
from collections.abc import Callable
from contextlib import nullcontext
from functools import cache
from pathlib import Path
from typing import Any

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

from tests.export.patching import JOINTS, ROBOT, effect, model, patched
from trundle.mechanism import (
    EffortDrive,
    JointEffect,
    Mechanism,
    MechanismModel,
    MechanismTable,
    PositionDrive,
    simulate,
)
from trundle.mechanism.simulation import JointLaws

Floats = NDArray[np.float64]

TIMES = np.linspace(0.0, 0.6, 601)
START = np.array([0.3, 0.5])


def control(t: float) -> Floats:
    return np.array([6.0 * math.sin(5 * t) - 4.0, 1.5 * math.sin(9 * t + 1)])


def play(folder: Path, start: Floats = START, drive: Callable[[float], Floats] = control) -> Floats:
    """Simulate the patched model in plain MuJoCo and return the positions of shoulder and elbow."""
    compiled = mujoco.MjModel.from_xml_path(str(folder / "robot.xml"))
    data = mujoco.MjData(compiled)
    data.qpos[:2] = start
    by_control = {compiled.actuator(k).trnid[0]: k for k in range(compiled.nu)}
    out = [data.qpos[:2].copy()]
    effects = exported_effects(folder, compiled) if (folder / "effects.py").exists() else None
    with nullcontext() if effects is None else effects.installed():
        for t in TIMES[:-1]:
            for k, value in enumerate(drive(t)):
                dof = compiled.joint(JOINTS[k]).dofadr[0]
                if dof in by_control:
                    data.ctrl[by_control[dof]] = value
                else:
                    data.qfrc_applied[dof] = value
            mujoco.mj_step(compiled, data)
            out.append(data.qpos[[compiled.joint(name).qposadr[0] for name in JOINTS]].copy())
    return np.array(out)


def exported_effects(folder: Path, compiled: mujoco.MjModel) -> Any:
    """Load `effects.py` of a patched model."""
    spec = importlib.util.spec_from_file_location("effects", folder / "effects.py")
    assert spec is not None
    assert spec.loader is not None
    module: Any = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.Effects(compiled)


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
    "early reading": (
        [effect("effort_delay", delay=-0.04)],
        lambda t: np.array([control(t)[0], control(t - 0.04)[1] if t >= 0.04 - 1e-9 else 0.0]),
    ),
    "two delays": (
        [effect("drive_delay", delay=0.025), effect("effort_delay", delay=-0.015)],
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


def test_a_slide_with_an_elastic_drive_moves_its_carriage(tmp_path: Path) -> None:
    text = """<mujoco><worldbody><body><joint name="rail" type="slide" axis="1 0 0" armature="1"/>
<geom size="0.1" mass="2" contype="0"/></body></worldbody></mujoco>"""
    described = MechanismModel(
        MechanismTable(["rail"], "robot.xml"), {}, [effect("joint_elasticity", "rail", stiffness=50.0)]
    )
    compiled = mujoco.MjModel.from_xml_path(str(patched(tmp_path, described, text) / "robot.xml"))
    data, matrix = mujoco.MjData(compiled), np.zeros((2, 2))
    mujoco.mj_forward(compiled, data)
    mujoco.mj_fullM(compiled, data, matrix)
    np.testing.assert_allclose(matrix, [[3.0, 2.0], [2.0, 2.0]], atol=1e-9)


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


def test_a_block_with_effects_leaves_callback_and_friction_as_before(tmp_path: Path) -> None:
    folder = patched(tmp_path, model(effect("joint_load_friction", coefficient=0.2)))
    compiled = mujoco.MjModel.from_xml_path(str(folder / "robot.xml"))
    data, friction, others = mujoco.MjData(compiled), compiled.dof_frictionloss.copy(), []
    mujoco.set_mjcb_passive(lambda _, data: others.append(data.time))
    try:
        with (
            pytest.raises(RuntimeError, match="in the block"),
            exported_effects(folder, compiled).installed(),
        ):
            for _ in range(20):
                mujoco.mj_step(compiled, data)
            assert not others
            assert not np.array_equal(compiled.dof_frictionloss, friction)
            raise RuntimeError("in the block")
        assert np.array_equal(compiled.dof_frictionloss, friction)
        mujoco.mj_step(compiled, data)
        assert others
    finally:
        mujoco.set_mjcb_passive(None)
    mujoco.MjModel.from_xml_path(str(folder / "robot.xml"))
