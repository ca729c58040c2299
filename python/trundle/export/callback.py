"""The effects of the `model.toml` next to this file, for MuJoCo.

`object.xml` describes the body and the actuators of the effects. trundle evaluates the effects.

    model, effects = load()                            # or Effects(your_model) if it includes object.xml
    data = mujoco.MjData(model)
    effects.apply(model, data); mujoco.mj_step(model, data)       # in your loop, before each step
    with effects.installed():                                     # or for all steps in this block
        mujoco.mj_step(model, data)
    effects.use(effects.sample(numpy.random.default_rng(0)))      # parameters from the posterior

MuJoCo loads no model while a Python callback is installed. Needs `mujoco` and `trundle`. Apply your own
forces as usual: `qfrc_applied`, `xfrc_applied`, contacts.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path

import mujoco
import numpy as np

from trundle.export import Laws, Model, TrundleError, draw

HERE = Path(__file__).resolve().parent

BODY = "object"
PUSH = ("push_x", "push_y", "push_theta")
DAMPING = ("damping_x", "damping_y", "damping_theta", "damping_xy", "damping_xtheta", "damping_ytheta")
IMPLICIT = (mujoco.mjtIntegrator.mjINT_IMPLICIT, mujoco.mjtIntegrator.mjINT_IMPLICITFAST)


def load(folder: str | Path = HERE) -> tuple[mujoco.MjModel, Effects]:
    """Return a compiled model of the object alone, and its effects."""
    model = mujoco.MjModel.from_xml_path(str(Path(folder) / "object.xml"))
    return model, Effects(model, folder)


class Effects:
    """The effects on one object of a MuJoCo model.

    Parameters
    ----------
    model : mujoco.MjModel
        A model that includes `object.xml`. The body must be a child of the world without rotation, with
        planar joints or a free joint.
    folder : path
        Folder of `model.toml`.
    parameters : mapping of str to float, optional
        Values that replace those of `model.toml`, as `sample` returns them.
    contact : float
        Start time of the contact, s, from which some effects act.
    episode : float
        Number of the episode to reproduce, from 0, for effects with an event; by default all events have
        occurred.
    """

    def __init__(
        self,
        model: mujoco.MjModel,
        folder: str | Path = HERE,
        parameters: Mapping[str, float] | None = None,
        *,
        contact: float = 0.0,
        episode: float = math.inf,
    ) -> None:
        if model.opt.integrator not in IMPLICIT:
            raise TrundleError('set option integrator="implicitfast": the damping of a wheel is stiff')
        self.model, self.contact, self.episode = model, contact, episode
        self.described = Model.read(Path(folder) / "model.toml")
        self.body = identify(model, mujoco.mjtObj.mjOBJ_BODY, BODY)
        self.free, self.qpos, self.dofs = coordinates(model, self.body)
        controls = [
            identify(model, mujoco.mjtObj.mjOBJ_ACTUATOR, f"{BODY}_{name}") for name in PUSH + DAMPING
        ]
        self.controls = np.array(controls)
        self.use(parameters or {})

    def sample(self, rng: np.random.Generator) -> dict[str, float]:
        """Draw a value for every parameter from the posterior of `model.toml`, within its bounds."""
        return draw(self.described, rng)

    def use(self, parameters: Mapping[str, float]) -> None:
        """Set the parameters, and the mass, mass centre and inertia of the body accordingly."""
        self.laws = Laws(self.described, dict(parameters))
        self.inner = slice(0, len(self.laws.starts))
        if self.model.nuserdata < self.inner.stop:
            raise TrundleError(f'the effects have states: set <size nuserdata="{self.inner.stop}"/>')
        self.model.body_mass[self.body] = self.laws.mass
        self.model.body_ipos[self.body, :2] = self.laws.com
        self.model.body_inertia[self.body] = self.laws.inertia
        mujoco.mj_setConst(self.model, mujoco.MjData(self.model))

    @contextmanager
    def installed(self) -> Iterator[None]:
        """Install the effects as MuJoCo's control callback; afterwards restore the one before."""
        before = mujoco.get_mjcb_control()
        mujoco.set_mjcb_control(self.apply)
        try:
            yield
        finally:
            mujoco.set_mjcb_control(before)

    def apply(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Set the controls of the effects for the next step; does nothing for another model."""
        if model.signature != self.model.signature:
            return
        pose, twist = self.state(data)
        push, damping, data.userdata[self.inner] = self.laws.step(
            pose,
            twist,
            self.others(data, pose),
            model.opt.timestep,
            data.time,
            contact=self.contact,
            episode=self.episode,
            inner=data.userdata[self.inner] if data.time > 0.0 else (),
        )
        xx, xy, yy, xt, yt, tt = damping
        # A symmetric matrix as a sum of squares along x, y, theta and the three sums of two of them.
        data.ctrl[self.controls] = (*push, xx - xy - xt, yy - xy - yt, tt - xt - yt, xy, xt, yt)

    def state(self, data: mujoco.MjData) -> tuple[tuple[float, ...], tuple[float, ...]]:
        """Return pose and twist of the object frame in the world."""
        place, q = self.model.body_pos[self.body], data.qpos[self.qpos]
        vx, vy, spin = data.qvel[self.dofs]
        if self.free:
            w, x, y, z = q[3:]
            return (q[0], q[1], np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z))), (vx, vy, spin)
        return (place[0] + q[0], place[1] + q[1], q[2]), (vx, vy, spin)

    def others(self, data: mujoco.MjData, pose: tuple[float, ...]) -> tuple[float, float, float]:
        """Return the wrench of all other forces, object axes about the origin; contacts are one step old."""
        fx, fy, torque = data.qfrc_applied[self.dofs] + data.qfrc_constraint[self.dofs]
        cos, sin = np.cos(pose[2]), np.sin(pose[2])
        fx, fy = cos * fx + sin * fy, cos * fy - sin * fx
        at_centre = data.xfrc_applied[self.body]
        weight = self.laws.mass * self.model.opt.gravity
        gx, gy = at_centre[0] + weight[0], at_centre[1] + weight[1]
        gx, gy = cos * gx + sin * gy, cos * gy - sin * gx
        x, y = self.laws.com
        return fx + gx, fy + gy, torque + at_centre[5] + x * gy - y * gx


def identify(model: mujoco.MjModel, kind: mujoco.mjtObj, name: str) -> int:
    """Return the index of a named element."""
    index = int(mujoco.mj_name2id(model, kind, name))
    if index < 0:
        raise TrundleError(f"the MuJoCo model has no {name!r}: include object.xml in it")
    return index


def coordinates(model: mujoco.MjModel, body: int) -> tuple[bool, slice, list[int]]:
    """Return whether the body has a free joint, its slice of `qpos`, and its x, y, theta in `qvel`."""
    joints = range(model.body_jntadr[body], model.body_jntadr[body] + model.body_jntnum[body])
    kinds = [int(model.jnt_type[joint]) for joint in joints]
    at, dof = model.jnt_qposadr[joints[0]] if joints else 0, model.body_dofadr[body]
    turned = abs(model.body_quat[body][0]) < 1 - 1e-9 and kinds != [int(mujoco.mjtJoint.mjJNT_FREE)]
    if model.body_parentid[body] != 0 or turned:
        raise TrundleError(f"{BODY!r} must be a child of the world without rotation")
    if kinds == [int(mujoco.mjtJoint.mjJNT_FREE)]:
        return True, slice(at, at + 7), [dof, dof + 1, dof + 5]
    if kinds != [int(mujoco.mjtJoint.mjJNT_SLIDE)] * 2 + [int(mujoco.mjtJoint.mjJNT_HINGE)]:
        raise TrundleError(f"{BODY!r} must have a free joint, or slide along x and y and turn about z")
    return False, slice(at, at + 3), [dof, dof + 1, dof + 2]
