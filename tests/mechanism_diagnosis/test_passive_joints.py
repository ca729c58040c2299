"""Joints without a drive: nothing but the other joints' efforts tells the size of their inertia."""

from __future__ import annotations

import numpy as np
import pytest

import trundle

mujoco = pytest.importorskip("mujoco")

CART_POLE = """<mujoco><option timestep="0.001"/><worldbody>
<body name="cart"><joint name="slider" type="slide" axis="1 0 0" damping="0.5"{slider}/>
<geom type="box" size=".1 .05 .05" mass="1.1"/>
<body name="pole"><joint name="hinge" axis="0 1 0" damping="0.002"{hinge}/>
<geom type="capsule" fromto="0 0 0 0 0 -.5" size=".015" mass=".22"/></body></body></worldbody>
<actuator><motor name="push" joint="slider"/></actuator></mujoco>"""
NOMINAL = CART_POLE.format(slider="", hinge="")


def cart_pole(slider: str = "", hinge: str = "") -> trundle.JointRecording:
    """Return a recording of a cart whose pole swings over large angles, by MuJoCo."""
    model = mujoco.MjModel.from_xml_string(CART_POLE.format(slider=slider, hinge=hinge))
    rng = np.random.default_rng(3)
    episodes = {}
    for number in range(5):
        data = mujoco.MjData(model)
        data.qpos[1] = rng.uniform(-1, 1)
        first, second = rng.uniform(2, 6, 2)
        rows = []
        for k in range(1200):
            t = k / 100
            data.ctrl[0] = 3 * np.sin(first * t) + 2 * np.sin(second * t + 1) - 4 * data.qpos[0]
            rows.append((t, *data.qpos, data.ctrl[0]))
            mujoco.mj_step(model, data, 10)
        noise = rng.standard_normal((len(rows), 4)) * [0, 1e-4, 5e-4, 0.02]
        table = np.array(rows) + noise
        names = ("t", "q_slider", "q_hinge", "effort_slider")
        episodes[f"e{number}"] = dict(zip(names, table.T, strict=True))
    metadata = {
        "format": "trundle-recording/2",
        "name": "cart-pole",
        "mechanism": {"model": "robot.xml", "joints": ["slider", "hinge"]},
        "effort": {"source": "commanded"},
        "split": {"held_out": ["e4"]},
    }
    return trundle.JointRecording(metadata, episodes, {"robot.xml": NOMINAL.encode()})


@pytest.mark.parametrize(
    ("truth", "expected"),
    [
        ({}, {}),
        ({"slider": ' frictionloss="0.9"'}, {"joint_dry_friction:slider": 0.9}),
        ({"hinge": ' frictionloss="0.012"'}, {"joint_dry_friction:hinge": 0.012}),
    ],
    ids=["clean", "cart", "pole"],
)
def test_friction_of_a_cart_pole(truth: dict[str, str], expected: dict[str, float]) -> None:
    found = trundle.diagnose(cart_pole(**truth))
    assert found.missing == list(expected)
    for effect, size in zip(found.answer["missing"], expected.values(), strict=True):
        assert effect["parameters"]["effort"]["mean"] == pytest.approx(size, rel=0.05)
    masses = {"mass:cart": 1.1, "mass:pole": 0.22}
    for name, mass in masses.items():
        assert found.model.nominal[name] == pytest.approx(mass, rel=0.2)
