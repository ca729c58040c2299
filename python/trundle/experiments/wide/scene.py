"""Scenes of the wide benchmark: an object, its wheel, instruments, and pushes, without hidden effects."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from trundle.experiments.blind.push import Grasp, Push, draw_grasp, draw_push
from trundle.experiments.blind.scene import Scene, Wheel, draw_point
from trundle.experiments.sampling import log_uniform
from trundle.experiments.wide.instrument import Instrument, draw_instrument
from trundle.experiments.wide.shapes import Outline, draw_outline
from trundle.experiments.wide.strokes import Strokes, draw_strokes

__all__ = ["ENGINES", "WideScene", "draw_wide_scene"]

ENGINES = ("mujoco", "ode")
MAX_TOTAL_DURATION_S = 120.0
"""Bound on the duration of all episodes of a recording, which bounds the cost of a case."""
INSTRUMENT_ATTEMPTS = 6
"""Number of scenes with one instrument before another instrument is drawn."""


@dataclass(frozen=True)
class WideScene(Scene):
    """A scene of the wide benchmark.

    Attributes
    ----------
    engine : str
        One of `ENGINES`.
    instrument : Instrument
    seconds : tuple of float
        Duration of each episode.
    compliance : (m/N, rad/(N·m))
        Compliance of the grasp.
    strokes : tuple of Strokes
        Strokes of free pushing in each episode; empty for a grasp.
    clock : tuple of float
        Offset of the time of each episode, s.
    rest : tuple of float
        Start of the recording of each episode, s, without the clock offset.
    """

    engine: str = "mujoco"
    instrument: Instrument | None = None
    seconds: tuple[float, ...] = ()
    compliance: tuple[float, float] = (0.0, 0.0)
    strokes: tuple[Strokes, ...] = ()
    clock: tuple[float, ...] = ()
    rest: tuple[float, ...] = ()

    @property
    def shape_kind(self) -> str:
        """Kind of the outline."""
        return self.shape.kind


def draw_wide_scene(seed: int, attempt: int, engine: str) -> WideScene:
    """Return the scene of a seed; each attempt gives another one."""
    instrument = draw_instrument(np.random.default_rng([seed, attempt // INSTRUMENT_ATTEMPTS, 11]))
    rng = np.random.default_rng([seed, attempt, 12])
    outline = draw_outline(rng)
    mass = round(log_uniform(rng, 4.0, 50.0), 2)
    seconds, pace = draw_lengths(rng), float(rng.uniform(0.5, 1.2))
    grasps = [draw_grasp(rng, outline) for _ in range(int(rng.integers(2, 5)))]
    pushes = tuple(with_pace(draw_push(rng, grasps[k % len(grasps)]), pace) for k in range(len(seconds)))
    gain = float(rng.uniform(60.0, 200.0))
    point = instrument.contact == "point"
    tip = Grasp(0.0, 0.0, float(rng.uniform(-np.pi, np.pi)))
    gyration = outline.gyration
    limit = (80.0, 50.0 * gyration)
    return WideScene(
        seed=seed,
        shape=outline,
        mass=mass,
        wheel=draw_scaled_wheel(rng, outline, mass),
        pushes=tuple(replace(push, grasp=tip) for push in pushes) if point else pushes,
        gain=(gain, 0.4 * gain * gyration),
        limit=limit,
        offset=tuple(rng.uniform(-1, 1, 3) * (3.0, 3.0, 0.3)),
        rate=instrument.sensor,
        feet_given=bool(rng.random() < 0.6) or outline.disc is not None,
        mass_given=bool(rng.random() < 0.3),
        held_out=1 if len(seconds) < 5 else 2,
        pose_noise=instrument.pose,
        heading_noise=instrument.heading / gyration,
        force_noise=instrument.force,
        torque_noise=instrument.torque,
        engine=engine,
        instrument=instrument,
        seconds=seconds,
        compliance=draw_compliance(rng, instrument.contact, limit),
        strokes=tuple(draw_strokes(rng, length) for length in seconds) if point else (),
        clock=tuple(np.round(rng.uniform(0, 30, len(seconds)) * instrument.shifted, 3).tolist()),
        rest=tuple(np.round(rng.uniform(0.0, 0.15, len(seconds)), 3).tolist()),
    )


def draw_lengths(rng: np.random.Generator) -> tuple[float, ...]:
    """Return the durations of 3 to 20 episodes of 2 to 20 s; medians 8 episodes and 6 s."""
    count = int(np.clip(np.round(np.exp(rng.normal(np.log(8.0), 0.4))), 3, 20))
    typical = float(np.exp(rng.normal(np.log(6.0), 0.4)))
    typical = min(typical, MAX_TOTAL_DURATION_S / count)
    drawn = np.clip(typical * np.exp(rng.normal(0.0, 0.15, count)), 2.0, 20.0)
    return tuple(np.round(drawn, 2).tolist())


def with_pace(push: Push, pace: float) -> Push:
    """Return a push at another pace along the same path."""
    return replace(push, amplitude=pace * push.amplitude, frequency=pace * push.frequency)


def draw_scaled_wheel(rng: np.random.Generator, outline: Outline, mass: float) -> Wheel:
    """Return a wheel under the object with friction proportional to the square root of the mass."""
    x, y = draw_point(rng, outline)
    mu_x, mu_y = np.exp(rng.uniform(np.log((4.0, 40.0)), np.log((40.0, 300.0)))) * np.sqrt(mass / 20.0)
    return Wheel(x, y, float(rng.uniform(-np.pi / 2, np.pi / 2)), float(mu_x), float(mu_y))


def draw_compliance(
    rng: np.random.Generator, contact: str, limit: tuple[float, float]
) -> tuple[float, float]:
    """Return a compliance that yields 3 to 20 mm and 0.03 to 0.2 rad at the limits of the grasp."""
    if contact != "compliant":
        return 0.0, 0.0
    return log_uniform(rng, 0.003, 0.02) / limit[0], log_uniform(rng, 0.03, 0.2) / limit[1]
