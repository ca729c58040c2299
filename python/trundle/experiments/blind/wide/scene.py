"""Scenes with random instruments and conventions, held by a grasp or pushed by a finger."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from trundle.experiments.blind.instrument import FRAMES, Instrument
from trundle.experiments.blind.push import (
    CONTACT_TIME_S,
    Grasp,
    Push,
    Stroke,
    Strokes,
    draw_grasp,
    draw_push,
)
from trundle.experiments.blind.scene import Scene, draw_wheel
from trundle.experiments.blind.wide.outlines import draw_outline
from trundle.experiments.sampling import log_uniform

__all__ = ["REFERENCE_WHEEL_MASS_KG", "draw_scene"]

MAX_TOTAL_DURATION_S = 120.0
"""Bound on the duration of all episodes of a recording, which bounds the cost of a case."""
INSTRUMENT_ATTEMPTS = 6
"""Number of scenes with one instrument before another instrument is drawn."""
FRAME_SHARES = (0.4, 0.08, 0.16, 0.08, 0.16, 0.12)
CONTACT_SHARES = {"grasp": 0.45, "compliant": 0.25, "point": 0.3}
MIN_STROKE_S = 1.2
"""Shortest stroke of a finger."""
REFERENCE_WHEEL_MASS_KG = 20.0
"""Mass for which a wheel's friction is that of furniture; it grows with the square root of the mass."""


def draw_scene(seed: int, attempt: int, engine: str) -> Scene:
    """Return the scene of a seed; each attempt gives another one."""
    instrument = draw_instrument(np.random.default_rng([seed, attempt // INSTRUMENT_ATTEMPTS, 11]))
    rng = np.random.default_rng([seed, attempt, 12])
    outline = draw_outline(rng)
    mass, gyration = round(log_uniform(rng, 4.0, 50.0), 2), outline.gyration
    seconds, pace = draw_lengths(rng), float(rng.uniform(0.5, 1.2))
    grasps = [draw_grasp(rng, outline) for _ in range(int(rng.integers(2, 5)))]
    pushes = tuple(with_pace(draw_push(rng, grasps[k % len(grasps)]), pace) for k in range(len(seconds)))
    gain = float(rng.uniform(60.0, 200.0))
    point = instrument.contact == "point"
    tip = Grasp(0.0, 0.0, float(rng.uniform(-np.pi, np.pi)))
    limit = (80.0, 50.0 * gyration)
    return Scene(
        seed=seed,
        shape=outline,
        mass=mass,
        wheel=draw_wheel(rng, outline, np.sqrt(mass / REFERENCE_WHEEL_MASS_KG)),
        pushes=tuple(replace(push, grasp=tip) for push in pushes) if point else pushes,
        seconds=seconds,
        gain=(gain, 0.4 * gain * gyration),
        limit=limit,
        offset=tuple(rng.uniform(-1, 1, 3) * (3.0, 3.0, 0.3)),
        instrument=instrument,
        pose_noise=(instrument.pose, instrument.pose, instrument.heading / gyration),
        wrench_noise=(instrument.force, instrument.force, instrument.torque),
        feet_given=bool(rng.random() < 0.6) or outline.disc is not None,
        mass_given=bool(rng.random() < 0.3),
        held_out=1 if len(seconds) < 5 else 2,
        engine=engine,
        compliance=draw_compliance(rng, instrument.contact, limit),
        strokes=tuple(draw_strokes(rng, length) for length in seconds) if point else (),
        clock=tuple(np.round(rng.uniform(0, 30, len(seconds)) * instrument.shifted, 3).tolist()),
        rest=tuple(np.round(rng.uniform(0.0, 0.15, len(seconds)), 3).tolist()),
    )


def draw_instrument(rng: np.random.Generator) -> Instrument:
    """Return random instruments and conventions."""
    tracker, sensor = log_uniform(rng, 10.0, 250.0), log_uniform(rng, 50.0, 1000.0)
    frame, reference = FRAMES[int(rng.choice(len(FRAMES), p=FRAME_SHARES))]
    contact = str(rng.choice(tuple(CONTACT_SHARES), p=tuple(CONTACT_SHARES.values())))
    force = log_uniform(rng, 0.05, 1.0)
    loses, jitters = rng.random() < 0.5, rng.random() < 0.5
    pose = log_uniform(rng, 1e-4, 3e-3)
    return Instrument(
        tracker=round(tracker, 1),
        sensor=round(sensor, 1),
        dropout=round(float(rng.uniform(0.05, 0.5)), 3) * loses,
        burst=bool(rng.random() < 0.5),
        jitter=jitters * min(0.1 / tracker, log_uniform(rng, 1e-4, 2e-3)),
        pose=pose,
        heading=pose * float(rng.uniform(0.6, 1.5)),
        force=force,
        torque=force * float(rng.uniform(0.05, 0.2)),
        filtered=bool(rng.random() < 0.5),
        frame=frame,
        reference=reference,
        sign=str(rng.choice(("on_object", "on_sensor"), p=(0.6, 0.4))),
        # An offset about the object's origin is constant only where the grasp is rigid.
        raw=frame == "sensor" and bool(rng.random() < 0.6) and (reference == "sensor" or contact == "grasp"),
        contact=contact,
        torque_given=contact != "point" or bool(rng.random() < 0.5),
        noise_given=bool(rng.random() < 0.6),
        shifted=bool(rng.random() < 0.3),
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


def draw_compliance(
    rng: np.random.Generator, contact: str, limit: tuple[float, float]
) -> tuple[float, float]:
    """Return a compliance that yields 3 to 20 mm and 0.03 to 0.2 rad at the limits of the grasp."""
    if contact != "compliant":
        return 0.0, 0.0
    return log_uniform(rng, 0.003, 0.02) / limit[0], log_uniform(rng, 0.03, 0.2) / limit[1]


def draw_strokes(rng: np.random.Generator, seconds: float) -> Strokes:
    """Return strokes that fill an episode."""
    strokes, t = [], CONTACT_TIME_S
    while seconds - t > MIN_STROKE_S:
        end = min(t + float(rng.uniform(MIN_STROKE_S, 3.5)), seconds)
        end = seconds if seconds - end < MIN_STROKE_S else end
        limits = ((0.0, 1.0), (-0.4, 0.4), (0.08, 0.35), (0.0, 1.2), (0.4, 1.5))
        strokes.append(Stroke(t, end, *(float(rng.uniform(*pair)) for pair in limits)))
        t = end
    stiffness = log_uniform(rng, 3e3, 3e4)
    return Strokes(tuple(strokes), stiffness, float(rng.choice([0.0, 0.15, 0.3])))
