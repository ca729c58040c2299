"""Exported models move in MuJoCo as in trundle."""

import importlib.util
import json
import subprocess
import sys
from pathlib import Path
from types import ModuleType

import mujoco
import numpy as np
import pytest
from numpy.typing import NDArray

import trundle
from tests.command import trundle as command
from trundle.export import to_mujoco
from trundle.export.shape import area, convex_pieces, is_convex

Floats = NDArray[np.float64]

SECONDS, SAMPLE = 4.0, 0.01
TOLERANCE = (2e-3, 3e-3)
"""Tolerances, m and rad, at MuJoCo's usual step of 2 ms; its positions lag by half a step."""

BODY = """
format = "trundle-model/1"
[body]
footprint = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]
mass = 20.0
"""
WHEEL = """
[[effect]]
kind = "viscous_wheel"
x = -0.5
y = -0.3
angle = 0.4
mu_x = 15.0
mu_y = 180.0
"""
LOCKED = WHEEL.replace("180.0", "1e5").replace("15.0", "3e4")
DRY = """
[[effect]]
kind = "coulomb_friction"
x = 0.4
y = 0.3
force = 14.0
static_force = 18.0
"""
FLOOR = """
[[effect]]
kind = "support_friction"
force = 20.0
spread = 1.0
"""
SLOPE = """
[[effect]]
kind = "floor_slope"
accel_x = 0.3
accel_y = -0.2
"""
CASTER = """
[[effect]]
kind = "caster_swivel"
x = 0.5
y = 0.3
trail = 0.05
mu_side = 60.0
"""
LOAD = """
[[effect]]
kind = "swinging_load"
x = 0.2
y = 0.1
mass = 5.0
frequency = 1.2
"""
TETHER = """
[[effect]]
kind = "tether"
x = 0.5
y = 0.0
anchor_x = 1.5
anchor_y = 0.5
stiffness = 30.0
rest_length = 0.6
"""
PATCH = """
[[effect]]
kind = "floor_patch"
x = 0.6
y = 0.0
half_length = 0.5
half_width = 0.5
angle = 0.0
mu = 30.0
"""
UNNAMED = """
[unnamed]
inputs = ["position", "heading"]
axes = "world"
scales = [0.6, 0.6, 0.8, 0.8]
centres = [[0.1, 0.0, 1.0, 0.0], [0.4, 0.2, 0.9, 0.4]]
weights = [[6.0, -4.0, 1.0], [-5.0, 7.0, -0.5]]
"""
POSTERIOR = """
[posterior]
names = ["body.mass", "viscous_wheel.mu_x", "viscous_wheel.mu_y"]
mean = [20.0, 15.0, 180.0]
covariance = [[4.0, 2.5, 0.0], [2.5, 100.0, 0.0], [0.0, 0.0, 400.0]]
"""
CASES = {
    "viscous wheel": BODY + WHEEL,
    "dry friction": BODY + WHEEL + DRY,
    "dry floor": BODY + FLOOR,
    "slope": BODY + WHEEL + SLOPE,
    "mass centre": BODY + "com = [0.25, -0.1]\n" + WHEEL,
    "locked wheel": BODY + LOCKED,
    "caster": BODY + WHEEL + CASTER,
    "swinging load": BODY + WHEEL + LOAD,
    "tether": BODY + WHEEL + TETHER,
    "patch with an edge": BODY + WHEEL + PATCH,
    "unnamed wrench": BODY + WHEEL + UNNAMED,
}


def push(t: float) -> Floats:
    """Return a push with pauses and reversals, off the mass centre; object axes."""
    return np.array([30.0 * np.sin(1.7 * t), 12.0 * np.sin(3.0 * t), 6.0 * np.sin(2.3 * t)])


def ours(text: str) -> Floats:
    t = np.linspace(0.0, SECONDS, round(SECONDS / SAMPLE) + 1)
    wrench = np.array([push(time) for time in t])
    poses, _ = trundle.Model.from_toml(text).rollout([0.3, -0.2, 0.5], [0.0, 0.0, 0.0], t, wrench)
    return poses


def loaded(folder: Path) -> ModuleType:
    spec = importlib.util.spec_from_file_location(f"effects_{folder.name}", folder / "effects.py")
    assert spec is not None and spec.loader is not None
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def theirs(folder: Path, timestep: float = 2e-3, by: str = "qfrc_applied") -> Floats:
    model, effects = loaded(folder).load()
    model.opt.timestep = timestep
    data = mujoco.MjData(model)
    data.qpos[:] = [0.3, -0.2, 0.5]
    every = round(SAMPLE / timestep)
    poses = [data.qpos.copy()]
    for step in range(round(SECONDS / timestep)):
        fx, fy, torque = push((step + 0.5) * timestep)
        cos, sin = np.cos(data.qpos[2]), np.sin(data.qpos[2])
        force = np.array([cos * fx - sin * fy, sin * fx + cos * fy])
        if by == "qfrc_applied":
            data.qfrc_applied[:3] = [*force, torque]
        else:
            x, y = effects.laws.com
            data.xfrc_applied[1] = [*force, 0.0, 0.0, 0.0, torque - (x * fy - y * fx)]
        effects.apply(model, data)
        mujoco.mj_step(model, data)
        if (step + 1) % every == 0:
            poses.append(data.qpos.copy())
    return np.array(poses)


def gap(a: Floats, b: Floats) -> tuple[float, float]:
    return float(np.abs(a - b)[:, :2].max()), float(np.abs(a - b)[:, 2].max())


@pytest.mark.parametrize("case", CASES)
def test_the_exported_object_moves_as_in_trundle(case: str, tmp_path: Path) -> None:
    folder = to_mujoco(trundle.Model.from_toml(CASES[case]), tmp_path / "object")
    expected = ours(CASES[case])
    position, heading = gap(theirs(folder), expected)
    assert position < TOLERANCE[0] and heading < TOLERANCE[1]
    if case != "locked wheel":
        assert np.ptp(expected, axis=0).max() > 0.1
    if "dry" not in case:
        # The times at which dry friction starts and stops depend on both step sizes.
        assert gap(theirs(folder, 5e-4), expected)[0] < 0.5 * position


def test_forces_at_the_mass_centre(tmp_path: Path) -> None:
    folder = to_mujoco(trundle.Model.from_toml(CASES["mass centre"]), tmp_path / "object")
    assert gap(theirs(folder, by="xfrc_applied"), theirs(folder)) < (1e-9, 1e-9)


def test_dry_friction_holds_against_a_contact(tmp_path: Path) -> None:
    """A contact that is unknown to the callback: the object moves only above breakaway."""
    folder = to_mujoco(trundle.Model.from_toml(BODY + LOCKED), tmp_path / "object")
    pusher = """
      <body name="pusher" pos="-0.7 -0.3 0.1"><joint name="pusher" type="slide" axis="1 0 0"/>
      <geom size="0.05" mass="1"/></body>"""
    text = (folder / "object.xml").read_text().replace("</worldbody>", f"{pusher}</worldbody>")
    (folder / "object.xml").write_text(text)
    model, effects = loaded(folder).load()
    data = mujoco.MjData(model)
    joint = model.joint("pusher").dofadr[0]
    for _ in range(1500):
        data.qfrc_applied[joint] = 30.0
        effects.apply(model, data)
        mujoco.mj_step(model, data)
    assert data.ncon > 0
    # 30 N on a wheel of 3e4 N·s/m and more: at most 1 mm/s.
    assert np.abs(data.qvel[:2]).max() < 1.5e-3
    assert 1e-4 < np.abs(data.qpos[0]) < 5e-3


def test_a_new_process_loads_the_export(tmp_path: Path) -> None:
    (tmp_path / "model.toml").write_text(CASES["dry friction"] + POSTERIOR)
    done = command(tmp_path, "export", "model.toml", "--mujoco", "--out", "object")
    assert done.returncode == 0, done.stderr
    assert done.stdout.split() == [
        f"object/{name}" for name in ("effects.py", "model.toml", "object.xml", "ranges.json")
    ]
    script = """
import mujoco, numpy
from effects import load
model, effects = load()
data = mujoco.MjData(model)
data.qvel[:] = [0.5, 0.0, 0.0]
effects.use(effects.sample(numpy.random.default_rng(3)))
with effects.installed():
    for _ in range(2000):
        mujoco.mj_step(model, data)
load()
print(repr(float(abs(data.qvel).max())), float(data.qpos[0]), float(model.body("object").mass[0]))
"""
    folder = tmp_path / "object"
    ran = subprocess.run(
        [sys.executable, "-c", script], cwd=folder, capture_output=True, text=True, timeout=120
    )
    assert ran.returncode == 0, ran.stderr
    speed, way, mass = map(float, ran.stdout.split())
    assert speed < 1e-4 and way > 0.02 and abs(mass - 20.0) > 1e-3


def test_draws_follow_the_posterior_and_stay_positive(tmp_path: Path) -> None:
    folder = to_mujoco(trundle.Model.from_toml(BODY + WHEEL + POSTERIOR), tmp_path / "object")
    _, effects = loaded(folder).load()
    rng = np.random.default_rng(1)
    drawn = [effects.sample(rng) for _ in range(4000)]
    mass, along, across = (
        np.array([d[k] for d in drawn]) for k in ("body.mass", "viscous_wheel.mu_x", "viscous_wheel.mu_y")
    )
    assert along.min() > 0.0
    assert abs(np.std(np.log(mass)) - 2.0 / 20.0) < 5e-3
    assert abs(np.std(np.log(along)) - 10.0 / 15.0) < 3e-2
    assert abs(np.corrcoef(np.log(mass), np.log(along))[0, 1] - 2.5 / 20.0) < 0.05
    assert abs(np.std(np.log(across)) - 20.0 / 180.0) < 5e-3
    assert {d["viscous_wheel.x"] for d in drawn} == {-0.5}
    exported = json.loads((folder / "ranges.json").read_text())["parameters"]["viscous_wheel.mu_x"]
    assert exported["low"] == pytest.approx(np.quantile(along, 0.025), rel=0.1)
    assert exported["high"] == pytest.approx(np.quantile(along, 0.975), rel=0.1)
    again = effects.sample(np.random.default_rng(1))
    assert again == drawn[0]


def test_a_drawn_model_is_the_simulated_one(tmp_path: Path) -> None:
    folder = to_mujoco(trundle.Model.from_toml(BODY + WHEEL), tmp_path / "object")
    model, effects = loaded(folder).load()
    effects.use({"body.mass": 31.0})
    assert model.body("object").mass[0] == 31.0
    assert model.body("object").inertia[2] == pytest.approx(31.0 * (1.2**2 + 0.8**2) / 12.0)
    with pytest.raises(trundle.TrundleError, match=r"unknown name `body.weight`"):
        effects.use({"body.weight": 31.0})


def test_shapes_become_geoms_of_the_same_area(tmp_path: Path) -> None:
    """A concave footprint, and a disc."""
    text = """
    format = "trundle-model/1"
    [body]
    mass = 10.0
    [[body.fixture]]
    polygon = [[0.0, 0.0], [0.0, 2.0], [1.0, 2.0], [1.0, 1.0], [2.0, 1.0], [2.0, 0.0]]
    [[body.fixture]]
    disc = [3.0, 0.5, 0.4]
    """
    folder = to_mujoco(trundle.Model.from_toml(text), tmp_path / "object")
    model = mujoco.MjModel.from_xml_path(str(folder / "object.xml"))
    assert (model.geom_type == mujoco.mjtGeom.mjGEOM_MESH).sum() == 4
    assert (model.geom_type == mujoco.mjtGeom.mjGEOM_CYLINDER).sum() == 1
    corners = [(0.0, 0.0), (0.0, 2.0), (1.0, 2.0), (1.0, 1.0), (2.0, 1.0), (2.0, 0.0)]
    for polygon in (corners, corners[::-1]):
        cut = convex_pieces(polygon)
        assert sum(map(area, cut)) == pytest.approx(3.0)
        assert all(is_convex(piece) for piece in cut)


def test_unsupported_input_is_refused(tmp_path: Path) -> None:
    bare = 'format = "trundle-model/1"\n[body]\nmass = 3.0\n'
    (tmp_path / "bare.toml").write_text(bare)
    (tmp_path / "free.toml").write_text(BODY + WHEEL.replace("mu_x = 15.0\n", ""))
    for name, said in (("bare.toml", "--footprint"), ("free.toml", "viscous_wheel.mu_x")):
        done = command(tmp_path, "export", name, "--out", "object")
        assert done.returncode == 2 and said in done.stderr and not (tmp_path / "object").exists()
    done = command(tmp_path, "export", "bare.toml", "--out", "object", "--footprint", "[[0,0],[1,0],[0,1]]")
    assert done.returncode == 0, done.stderr
    mine = tmp_path / "mine"
    mine.mkdir()
    (mine / "thesis.tex").write_text("")
    done = command(tmp_path, "export", "bare.toml", "--out", "mine", "--footprint", "[[0,0],[1,0],[0,1]]")
    assert done.returncode == 2 and "is not empty" in done.stderr and (mine / "thesis.tex").exists()
