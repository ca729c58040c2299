"""Effects of the catalogue of joints, made by MuJoCo's features or by equations of motion of their own."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from trundle.experiments.blind.mechanism.family import Draw, Family, State, Statistics, Values
from trundle.experiments.blind.mechanism.scene import TIME_STEP, Scene
from trundle.experiments.sampling import Floats, log_uniform
from trundle.mechanism.transmissions import couple_slides

__all__ = ["CATALOGUE", "split_joint"]

Rng = np.random.Generator


def of_effort(
    name: str, low: float, high: float, unit: Callable[[Statistics, int], float], signed: bool = False
) -> Draw:
    """Draw one value between two limits, in units of the motion without the effect."""

    def draw(rng: Rng, scene: Scene, seen: Statistics, j: int) -> Values:
        sign = rng.choice([-1.0, 1.0]) if signed else 1.0
        return {name: float(sign * log_uniform(rng, low, high) * unit(seen, j))}

    return draw


def draw_dry(rng: Rng, scene: Scene, seen: Statistics, j: int) -> Values:
    effort = float(log_uniform(rng, 0.08, 0.6) * seen.effort[j])
    return {
        "effort": effort,
        "static_effort": effort * float(rng.choice([1.0, rng.uniform(1.1, 1.6)])),
        "velocity": float(seen.speed[j] * rng.uniform(0.05, 0.2)),
    }


def dry_level(values: Values, s: State) -> float:
    speed = s.v[values["joint"]] / values["velocity"]
    return float(values["effort"] + (values["static_effort"] - values["effort"]) * np.exp(-(speed**2)))


def load_level(values: Values, s: State) -> float:
    j = values["joint"]
    return float(values["coefficient"] * abs(s.u[j] + s.external()[j]))


def directional(values: Values, s: State, out: Floats) -> None:
    j = values["joint"]
    out[j] -= values["viscous_difference"] * abs(s.v[j])


def drag(values: Values, s: State, out: Floats) -> None:
    j = values["joint"]
    out[j] -= values["coefficient"] * abs(s.v[j]) * s.v[j]


def cogging(values: Values, s: State, out: Floats) -> None:
    j = values["joint"]
    out[j] += values["amplitude"] * np.sin(2 * np.pi * s.q[j] / values["period"] + values["phase"])


def draw_cogging(rng: Rng, scene: Scene, seen: Statistics, j: int) -> Values:
    return {
        "period": float(seen.span(j) * log_uniform(rng, 0.06, 0.4)),
        "amplitude": float(seen.effort[j] * log_uniform(rng, 0.1, 0.5)),
        "phase": float(rng.uniform(-np.pi, np.pi)),
    }


def draw_spring(rng: Rng, scene: Scene, seen: Statistics, j: int) -> Values:
    stiffness = seen.effort[j] / seen.span(j) * log_uniform(rng, 0.3, 2.0)
    return {"stiffness": float(stiffness), "rest": seen.position(j, rng.uniform(0.1, 0.9))}


def spring(values: Values, s: State, out: Floats) -> None:
    j = values["joint"]
    out[j] -= values["stiffness"] * (s.q[j] - values["rest"])


def native_spring(spec: Any, joint: str, values: Values) -> None:
    found = spec.joint(joint)
    found.stiffness, found.springref = [values["stiffness"], 0.0, 0.0], values["rest"]


def draw_stop(rng: Rng, scene: Scene, seen: Statistics, j: int) -> Values:
    side = int(rng.choice([-1, 1]))
    quantile = rng.uniform(0.75, 0.93)
    position = seen.position(j, quantile if side > 0 else 1 - quantile)
    stiffness = scene.inertia[j] * (2 * np.pi * rng.uniform(2.0, 8.0)) ** 2
    return {"position": position, "stiffness": float(stiffness), "side": side}


def stop(values: Values, s: State, out: Floats) -> None:
    j, side = values["joint"], values["side"]
    depth = side * (s.q[j] - values["position"])
    if depth > 0.0:
        out[j] -= side * values["stiffness"] * depth


def split_joint(spec: Any, joint: str) -> Any:
    """Add a joint JOINT_play to the link of a joint, which then is the drive's; return it."""
    own = spec.joint(joint)
    body = own.parent
    couple_slides(own)
    return body.add_joint(name=f"{joint}_play", type=own.type, axis=own.axis, pos=own.pos)


def native_backlash(spec: Any, joint: str, values: Values) -> None:
    play = split_joint(spec, joint)
    play.limited, play.range = True, [-values["gap"] / 2, values["gap"] / 2]
    play.solref_limit, play.solimp_limit = [0.002, 1.0], [0.95, 0.99, 1e-4 * values["gap"], 0.5, 2]


def backlash(values: Values, x: float, v: float) -> float:
    depth = abs(x) - values["gap"] / 2
    if depth <= 0.0:
        return 0.0
    return float(np.sign(x) * max(values["contact"] * depth + np.sign(x) * 2e-3 * values["contact"] * v, 0.0))


def draw_backlash(rng: Rng, scene: Scene, seen: Statistics, j: int) -> Values:
    contact = scene.inertia[j] * (2 * np.pi * 25.0) ** 2
    return {"gap": float(seen.span(j) * log_uniform(rng, 0.004, 0.05)), "contact": float(contact)}


def native_elasticity(spec: Any, joint: str, values: Values) -> None:
    play = split_joint(spec, joint)
    play.stiffness, play.damping = [values["stiffness"], 0.0, 0.0], [values["damping"], 0.0, 0.0]


def elasticity(values: Values, x: float, v: float) -> float:
    return float(values["stiffness"] * x + values["damping"] * v)


def draw_elasticity(rng: Rng, scene: Scene, seen: Statistics, j: int) -> Values:
    f = 2 * np.pi * log_uniform(rng, 5.0, 20.0)
    inertia = scene.inertia[j]
    damping = 2 * rng.uniform(0.05, 0.3) * inertia * f
    return {"stiffness": float(inertia * f**2), "damping": float(damping)}


def draw_payload(rng: Rng, scene: Scene, seen: Statistics, j: int) -> Values:
    body = scene.robot.bodies[rng.integers(len(scene.robot.bodies))]
    com = rng.uniform(-0.2, 0.2, 3)
    mass = scene.robot.masses[body] * rng.uniform(0.15, 0.8)
    return {
        "body": body,
        "mass": float(mass),
        **dict(zip(("com_x", "com_y", "com_z"), com.tolist(), strict=True)),
    }


def add_payload(spec: Any, joint: str, values: Values) -> None:
    place = [values["com_x"], values["com_y"], values["com_z"]]
    extra = spec.body(values["body"]).add_body(name="hidden_payload", pos=place)
    extra.mass, extra.inertia, extra.explicitinertial = values["mass"], [1e-7, 1e-7, 1e-7], True


def add_armature(spec: Any, joint: str, values: Values) -> None:
    spec.joint(joint).armature += values["armature"]


def add_damping(spec: Any, joint: str, values: Values) -> None:
    found = spec.joint(joint)
    found.damping = [found.damping[0] + values["damping"], 0.0, 0.0]


def tilt(spec: Any, joint: str, values: Values) -> None:
    a, b = values["angle_x"], values["angle_y"]
    about_x = np.array([[1, 0, 0], [0, np.cos(a), -np.sin(a)], [0, np.sin(a), np.cos(a)]])
    about_y = np.array([[np.cos(b), 0, np.sin(b)], [0, 1, 0], [-np.sin(b), 0, np.cos(b)]])
    spec.option.gravity = about_y @ about_x @ [0.0, 0.0, -9.81]


def draw_tilt(rng: Rng, scene: Scene, seen: Statistics, j: int) -> Values:
    angle, size = rng.uniform(0, 2 * np.pi), log_uniform(rng, 0.03, 0.2)
    return {"angle_x": float(size * np.cos(angle)), "angle_y": float(size * np.sin(angle))}


def gain(values: Values, seen: Any) -> None:
    seen.effort[:, values["joint"]] *= values["gain"]


def bias(values: Values, seen: Any) -> None:
    seen.effort[:, values["joint"]] += values["bias"]


def late(values: Values, seen: Any) -> None:
    j = values["joint"]
    seen.effort[:, j] = np.interp(seen.t - values["delay"], seen.t, seen.effort[:, j])


def lagging(values: Values, seen: Any) -> None:
    j, share = values["joint"], 1.0 - np.exp(-TIME_STEP / values["time_constant"])
    y, column = seen.effort[0, j], seen.effort[:, j]
    for k, x in enumerate(column):
        y += share * (x - y)
        column[k] = y


def offset(values: Values, seen: Any) -> None:
    seen.q[:, values["joint"]] += values["offset"]


def delayed_drive(values: Values) -> Callable[[Floats], Floats]:
    buffer: list[float] = []
    late, j = round(values["delay"] / TIME_STEP), values["joint"]

    def act(u: Floats) -> Floats:
        buffer.append(float(u[j]))
        u = u.copy()
        u[j] = buffer[max(len(buffer) - 1 - late, 0)]
        return u

    return act


def lagging_drive(values: Values) -> Callable[[Floats], Floats]:
    last: list[float] = []
    share, j = 1.0 - np.exp(-TIME_STEP / values["time_constant"]), values["joint"]

    def act(u: Floats) -> Floats:
        if not last:
            last.append(float(u[j]))
        last[0] += share * (u[j] - last[0])
        u = u.copy()
        u[j] = last[0]
        return u

    return act


def drooping_drive(values: Values) -> Callable[[Floats], Floats]:
    j = values["joint"]

    def act(u: Floats) -> Floats:
        u = u.copy()
        u[j] *= 1.0 - values["droop"] * min(abs(u[j]) / values["largest"], 1.0)
        return u

    return act


def saturated_drive(values: Values) -> Callable[[Floats], Floats]:
    j, limit = values["joint"], values["limit"]

    def act(u: Floats) -> Floats:
        u = u.copy()
        u[j] = min(max(u[j], -limit), limit)
        return u

    return act


def per_controller(name: str) -> Draw:
    """Draw a time that the controller tolerates."""
    return lambda rng, scene, seen, j: {name: float(log_uniform(rng, 0.1, 0.4) / scene.natural)}


def draw_droop(rng: Rng, scene: Scene, seen: Statistics, j: int) -> Values:
    # The drooping drive needs the largest effort of the motion at its largest command.
    droop = float(rng.uniform(0.1, 0.4))
    return {"droop": droop, "largest": float(seen.largest[j]) / (1.0 - droop)}


def draw_gain(rng: Rng, scene: Scene, seen: Statistics, j: int) -> Values:
    return {"gain": float(np.exp(rng.choice([-1, 1]) * rng.uniform(0.08, 0.35)))}


def effort_of(s: Statistics, j: int) -> float:
    return float(s.effort[j])


READ, COMMANDED = ("measured", "current"), ("commanded",)
FAMILIES = (
    Family("joint_dry_friction", draw_dry, level=dry_level),
    Family(
        "joint_viscous_friction",
        of_effort("damping", 0.1, 0.8, lambda s, j: float(s.effort[j] / s.speed[j])),
        fixed="damping",
        model=add_damping,
    ),
    Family(
        "joint_directional_friction",
        of_effort("viscous_difference", 0.08, 0.6, lambda s, j: float(s.effort[j] / s.speed[j]), signed=True),
        force=directional,
    ),
    Family(
        "joint_load_friction",
        lambda rng, scene, seen, j: {"coefficient": float(rng.uniform(0.06, 0.4))},
        level=load_level,
    ),
    Family("joint_backlash", draw_backlash, native=native_backlash, transmission=backlash),
    Family("joint_elasticity", draw_elasticity, native=native_elasticity, transmission=elasticity),
    Family("joint_stop", draw_stop, force=stop),
    Family("joint_cogging", draw_cogging, force=cogging),
    Family("joint_spring", draw_spring, native=native_spring, force=spring),
    Family(
        "rotor_inertia",
        lambda rng, scene, seen, j: {"armature": float(scene.inertia[j] * log_uniform(rng, 0.1, 0.8))},
        fixed="armature",
        model=add_armature,
    ),
    Family("payload", draw_payload, model=add_payload, body=True),
    Family("base_tilt", draw_tilt, model=tilt, without_place=True),
    Family(
        "air_drag",
        of_effort("coefficient", 0.1, 0.8, lambda s, j: float(s.effort[j] / s.speed[j] ** 2)),
        force=drag,
    ),
    Family("effort_gain", draw_gain, sources=READ, distort=gain),
    Family("effort_bias", of_effort("bias", 0.06, 0.5, effort_of, signed=True), sources=READ, distort=bias),
    Family("effort_delay", of_effort("delay", 0.004, 0.04, lambda s, j: 1.0), sources=READ, distort=late),
    Family(
        "effort_lag", of_effort("time_constant", 0.004, 0.04, lambda s, j: 1.0), sources=READ, distort=lagging
    ),
    Family("drive_delay", per_controller("delay"), sources=("commanded", "target"), drive=delayed_drive),
    Family(
        "drive_lag", per_controller("time_constant"), sources=("commanded", "target"), drive=lagging_drive
    ),
    Family("drive_gain_droop", draw_droop, sources=COMMANDED, drive=drooping_drive),
    Family(
        "effort_saturation",
        of_effort("limit", 0.35, 0.85, lambda s, j: float(s.largest[j])),
        sources=COMMANDED,
        drive=saturated_drive,
    ),
    Family(
        "encoder_offset", of_effort("offset", 0.01, 0.08, lambda s, j: s.span(j), signed=True), distort=offset
    ),
)
CATALOGUE = {one.name: one for one in FAMILIES}
