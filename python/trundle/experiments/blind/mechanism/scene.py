"""Draw the scene of a case: robot, true masses, trajectories, drive and instrument."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import mujoco
import numpy as np

from trundle.experiments.blind.mechanism.robots import Robot
from trundle.experiments.sampling import Floats, log_uniform

__all__ = ["SOURCES", "TIME_STEP", "Scene", "draw_scene"]

TIME_STEP = 0.0005
"""Of both engines, s."""
RATES = (50, 100, 125, 200, 250, 400, 500, 1000)
"""Sampling rates, Hz: whole numbers of time steps."""
SOURCES = ("measured", "commanded", "current", "target")
SOURCE_WEIGHTS = (0.4, 0.3, 0.2, 0.1)
TOTAL_S = (24.0, 36.0)
"""Total length of the episodes, s."""


@dataclass(frozen=True)
class Scene:
    """What a case has in addition to its effects.

    Attributes
    ----------
    robot : Robot
        As it is given in the recording.
    truth : dict
        Factors of the true over the given masses, armatures and dampings: by body, by joint, by joint.
    source : str
        One of `SOURCES`.
    rate : int
        Of the recording and of the commands, Hz.
    length : float
        Of an episode, s.
    payloads : sequence of float or None
        By episode, the mass on the last body, kg. It is given.
    waves : sequence
        By episode and joint, the parameters of the reference.
    natural : float
        Natural frequency of the controller, rad/s.
    instrument : dict
        `position_noise` by joint, `position_step`, `effort_noise` (share of the rms effort), `noise_given`,
        `gain`, `stiffness_free`, `side`, `at_rest`.
    fixed : sequence of str
        Parameters of the nominal model that are not free, such as "armature:elbow".
    """

    robot: Robot
    truth: Mapping[str, Mapping[str, float]]
    source: str
    rate: int
    length: float
    payloads: Sequence[float | None]
    waves: Sequence[Sequence[Mapping[str, Any]]]
    natural: float
    instrument: Mapping[str, Any]
    fixed: Sequence[str]

    @property
    def n(self) -> int:
        """Number of joints."""
        return len(self.robot.joints)

    @property
    def last_body(self) -> str:
        """The body that carries payloads."""
        return self.robot.bodies[-1]

    @cached_property
    def inertia(self) -> Floats:
        """Diagonal of the given mass matrix in the middle of the spans, (n,)."""
        model = mujoco.MjModel.from_xml_string(self.robot.text)
        data, full = mujoco.MjData(model), np.zeros((model.nv, model.nv))
        data.qpos[:] = [np.mean(span) for span in self.robot.spans.values()]
        mujoco.mj_forward(model, data)
        mujoco.mj_fullM(model, data, full)
        return np.diag(full).copy()

    def gains(self) -> tuple[Floats, Floats]:
        """Return stiffness and damping of the controller, (n,) each."""
        return self.inertia * self.natural**2, 1.4 * self.inertia * self.natural

    def reference(self, episode: int) -> Floats:
        """Return the reference, (T, n), at every time step."""
        t: Floats = np.arange(round(self.length / TIME_STEP), dtype=np.float64) * TIME_STEP
        return np.column_stack([wave(t, one) for one in self.waves[episode]])


def wave(t: Floats, one: Mapping[str, Any]) -> Any:
    """Return a reference over time, (T,)."""
    kind, middle, size, f = one["kind"], one["middle"], one["size"], one["frequency"]
    if kind == "sines":
        shares = np.array(one["shares"]) / np.sum(one["shares"])
        phases = 2 * np.pi * f * np.outer(t, one["ratios"]) + one["phases"]
        return middle + size * (np.sin(phases) @ shares)
    if kind == "chirp":
        rise = one["rise"]
        return middle + size * np.sin(
            2 * np.pi * f * (t + (rise - 1.0) * t**2 / (2 * t[-1])) + one["phases"][0]
        )
    phase = (f * t + one["phases"][0]) % 1.0
    triangle = 4.0 * np.abs(phase - 0.5) - 1.0
    if kind == "ramps":
        return middle + size * triangle
    levels = np.array(one["levels"])
    position = f * t * 2
    index = position.astype(int)
    s = np.clip((position - index) / one["shares"][0], 0.0, 1.0)
    smooth = s**3 * (10 - 15 * s + 6 * s**2)
    low, high = levels[index % len(levels)], levels[(index + 1) % len(levels)]
    return middle + size * (low + (high - low) * smooth)


def draw_wave(rng: np.random.Generator, span: tuple[float, float], natural: float) -> dict[str, Any]:
    """Draw a reference within a span."""
    half = 0.5 * (span[1] - span[0])
    size = half * rng.uniform(0.35, 0.95)
    kind = str(rng.choice(["sines", "sines", "chirp", "ramps", "steps"]))
    slow = 0.12 if kind == "chirp" else 0.15
    return {
        "kind": kind,
        "middle": float(0.5 * (span[0] + span[1]) + (half - size) * rng.uniform(-1, 1)),
        "size": float(size),
        "frequency": log_uniform(rng, slow, min(0.5, 0.02 * natural)),
        "rise": float(rng.uniform(2.0, 5.0)),
        "ratios": [1.0, float(rng.uniform(1.3, 2.2)), float(rng.uniform(2.3, 3.5))],
        "shares": [1.0, float(rng.uniform(0.2, 0.8)), float(rng.uniform(0.05, 0.4))],
        "phases": rng.uniform(0, 2 * np.pi, 3).tolist(),
        "levels": rng.uniform(-1, 1, 9).tolist(),
    }


def draw_scene(
    rng: np.random.Generator, robots: Sequence[Robot], sources: Sequence[str], needs_fixed: str | None
) -> Scene:
    """Draw a scene whose source of effort is one of `sources`."""
    robot = robots[int(rng.integers(len(robots)))]
    weights = np.array([w for w, one in zip(SOURCE_WEIGHTS, SOURCES, strict=True) if one in sources])
    source = str(rng.choice([one for one in SOURCES if one in sources], p=weights / weights.sum()))
    bodies, joints = robot.bodies, robot.joints
    exact = rng.random() < 0.4
    off = 0.0 if exact else 0.1
    truth = {
        "mass": {body: float(rng.uniform(1 - off, 1 + off)) for body in bodies},
        "armature": {joint: log_uniform(rng, 0.75, 1.35) for joint in joints},
        "damping": {joint: log_uniform(rng, 0.6, 1.7) for joint in joints},
    }
    fixed = draw_fixed(rng, joints, needs_fixed)
    for name in fixed:
        kind, joint = name.split(":")
        truth[kind][joint] = 1.0
    length = float(rng.uniform(4.0, 10.0))
    count = int(np.clip(round(rng.uniform(*TOTAL_S) / length), 4, 10))
    several = rng.random() < 0.3
    mass = robot.masses[bodies[-1]]
    payloads = [
        float(mass * rng.uniform(0.1, 0.8)) if several and rng.random() < 0.5 else None for _ in range(count)
    ]
    natural = float(2 * np.pi * rng.uniform(2.5, 6.0))
    waves = [[draw_wave(rng, span, natural) for span in robot.spans.values()] for _ in range(count)]
    return Scene(
        robot,
        truth,
        source,
        int(rng.choice([one for one in RATES if one >= (200 if source == "target" else 50)])),
        round(length, 1),
        payloads,
        waves,
        natural,
        draw_instrument(rng, robot),
        fixed,
    )


def draw_fixed(rng: np.random.Generator, joints: Sequence[str], needed: str | None) -> list[str]:
    """Draw which parameters of the nominal model are not free; at least one of a needed kind."""
    fixed = []
    for kind in ("armature", "damping"):
        if kind == needed or rng.random() < 0.2:
            fixed += [f"{kind}:{joint}" for joint in joints]
    return fixed


def draw_instrument(rng: np.random.Generator, robot: Robot) -> dict[str, Any]:
    """Draw noise, quantisation, gain, the side of the encoders and what is given."""
    relative = log_uniform(rng, 2e-5, 5e-4)
    step = log_uniform(rng, 3e-5, 1e-3) if rng.random() < 0.5 else 0.0
    spans = {joint: high - low for joint, (low, high) in robot.spans.items()}
    return {
        "position_noise": {joint: relative * span for joint, span in spans.items()},
        "position_step": {joint: step * span / 3.0 for joint, span in spans.items()},
        "effort_noise": log_uniform(rng, 0.002, 0.03),
        "noise_given": bool(rng.random() < 0.5),
        "gain": log_uniform(rng, 0.05, 20.0),
        "stiffness_free": bool(rng.random() < 0.5),
        "side": "drive" if rng.random() < 0.3 else "joint",
    }
