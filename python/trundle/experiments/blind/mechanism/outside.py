"""Effects for which the catalogue of joints has no law."""

from __future__ import annotations

from typing import Any

import numpy as np

from trundle.experiments.blind.mechanism.families import READ, Rng, split_joint
from trundle.experiments.blind.mechanism.family import Family, State, Statistics, Values
from trundle.experiments.blind.mechanism.scene import TIME_STEP, Scene
from trundle.experiments.sampling import Floats, log_uniform

__all__ = ["OUT_OF_CATALOGUE"]


def draw_disturbance(rng: Rng, scene: Scene, seen: Statistics, j: int) -> Values:
    return {
        "amplitude": float(seen.effort[j] * rng.uniform(0.25, 0.7)),
        "period": float(rng.uniform(0.7, 4.0)),
        "phase": float(rng.uniform(0, 6.28)),
    }


def disturbance(values: Values, s: State, out: Floats) -> None:
    out[values["joint"]] += values["amplitude"] * np.sin(2 * np.pi * s.t / values["period"] + values["phase"])


def draw_cubic(rng: Rng, scene: Scene, seen: Statistics, j: int) -> Values:
    half = 0.5 * seen.span(j)
    return {
        "middle": seen.position(j, 0.5),
        "coefficient": float(seen.effort[j] / (seen.speed[j] * half**2) * rng.uniform(0.6, 2.0)),
    }


def cubic(values: Values, s: State, out: Floats) -> None:
    j = values["joint"]
    out[j] -= values["coefficient"] * (s.q[j] - values["middle"]) ** 2 * s.v[j]


def draw_hysteresis(rng: Rng, scene: Scene, seen: Statistics, j: int) -> Values:
    return {
        "effort": float(seen.effort[j] * rng.uniform(0.3, 0.8)),
        "stretch": float(seen.span(j) * rng.uniform(0.1, 0.3)),
    }


def hysteresis(values: Values, s: State, out: Floats) -> None:
    """Bouc-Wen spring: z' = v·(1 - abs(z)^2·(0.7 + 0.3·sign(v z))) / stretch."""
    j = values["joint"]
    z = s.memory.get("hysteresis", 0.0)
    change = s.v[j] * (1.0 - z * z * (0.7 + 0.3 * np.sign(s.v[j] * z))) / values["stretch"]
    s.memory["hysteresis"] = z = float(np.clip(z + TIME_STEP * change, -1.3, 1.3))
    out[j] -= values["effort"] * z


def draw_coupling(rng: Rng, scene: Scene, seen: Statistics, j: int) -> Values | None:
    if scene.n < 2:
        return None
    other = j - 1 if j else 1
    scale = 2 * np.pi / (0.5 * np.hypot(seen.span(j), seen.span(other)))
    size = min(seen.effort[j], seen.effort[other])
    return {
        "other": other,
        "amplitude": float(size * rng.uniform(0.3, 0.9)),
        "wave": float(scale * rng.uniform(0.6, 1.5)),
    }


def coupling(values: Values, s: State, out: Floats) -> None:
    """Add a potential of the difference of two joints, as between magnets."""
    j, other = values["joint"], values["other"]
    effort = values["amplitude"] * np.sin(values["wave"] * (s.q[j] - s.q[other]))
    out[j] -= effort
    out[other] += effort


def draw_position_friction(rng: Rng, scene: Scene, seen: Statistics, j: int) -> Values:
    return {
        "effort": float(seen.effort[j] * rng.uniform(0.3, 0.7)),
        "period": float(seen.span(j) * rng.uniform(0.25, 0.8)),
        "phase": float(rng.uniform(0, 6.28)),
    }


def position_friction(values: Values, s: State) -> float:
    wave = np.sin(2 * np.pi * s.q[values["joint"]] / values["period"] + values["phase"])
    return float(values["effort"] * max(0.5 + 0.9 * wave, 0.02))


def draw_heating(rng: Rng, scene: Scene, seen: Statistics, j: int) -> Values:
    return {"swing": float(rng.uniform(0.25, 0.5)), "time": float(rng.uniform(1.0, 4.0))}


def heating(values: Values, seen: Any) -> None:
    """Let the gain swing within an episode, as of a hot sensor."""
    wave = np.sin(2 * np.pi * seen.t / values["time"])
    seen.effort[:, values["joint"]] *= 1.0 + values["swing"] * wave


def draw_slip(rng: Rng, scene: Scene, seen: Statistics, j: int) -> Values:
    return {
        "limit": float(seen.effort[j] * rng.uniform(0.8, 1.4)),
        "rate": float(seen.span(j) * rng.uniform(0.15, 0.5)),
    }


def slip(values: Values, seen: Any) -> None:
    """Let a belt between encoder and joint creep while the effort is above a limit."""
    j = values["joint"]
    excess = np.clip(np.abs(seen.effort[:, j]) / values["limit"] - 1.0, 0.0, 1.0) * np.sign(seen.effort[:, j])
    seen.q[:, j] += values["rate"] * np.cumsum(excess) * TIME_STEP


def draw_progressive(rng: Rng, scene: Scene, seen: Statistics, j: int) -> Values:
    f = 2 * np.pi * log_uniform(rng, 3.0, 6.0)
    stiffness = scene.inertia[j] * f**2
    stretch = seen.effort[j] / stiffness
    return {
        "stiffness": float(stiffness),
        "cubic": float(stiffness / stretch**2 * rng.uniform(1.0, 5.0)),
        "damping": float(0.2 * scene.inertia[j] * f),
    }


def native_progressive(spec: Any, joint: str, values: Values) -> None:
    play = split_joint(spec, joint)
    # MuJoCo's polynomial stiffness: stiffness[0] + stiffness[1]·abs(x) + stiffness[2]·x².
    play.stiffness = [values["stiffness"], 0.0, values["cubic"]]
    play.damping = [values["damping"], 0.0, 0.0]


def progressive(values: Values, x: float, v: float) -> float:
    return float((values["stiffness"] + values["cubic"] * x * x) * x + values["damping"] * v)


FAMILIES = (
    Family("time_varying_disturbance", draw_disturbance, True, force=disturbance),
    Family("position_viscous_friction", draw_cubic, True, force=cubic),
    Family("hysteresis_spring", draw_hysteresis, True, force=hysteresis),
    Family("magnetic_coupling", draw_coupling, True, force=coupling),
    Family("position_dry_friction", draw_position_friction, True, level=position_friction),
    Family("drifting_gain", draw_heating, True, READ, distort=heating),
    Family("slipping_belt", draw_slip, True, distort=slip),
    Family(
        "progressive_elasticity",
        draw_progressive,
        True,
        native=native_progressive,
        transmission=progressive,
    ),
)
OUT_OF_CATALOGUE = {one.name: one for one in FAMILIES}
