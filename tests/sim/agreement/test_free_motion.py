"""Nothing in the way: recordings of `trundle simulate` against MuJoCo, for every effect of the catalogue.

Two references. `trundle export` is what a user gets for MuJoCo; its forces know trundle's own rule for a
step, so what is compared is all else of two worlds. Independent of every rule of ours is `integrated`: the
momentary wrench of the laws under MuJoCo's Runge-Kutta rule of fourth order. It carries no states of laws'
own, a caster's and a load's; that those laws, and others, are what real bodies on hinges and springs do is
for tests/laws.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import minimize_scalar

from tests.sim.agreement.effects import ON_INSTRUMENTS, ON_OBJECT, PUSH, STATELESS, WHEEL, effect_of
from tests.sim.agreement.scene import (
    CONTACT,
    STEP,
    Effect,
    Floats,
    assert_alike,
    exported,
    gap,
    integrated,
    model,
    poses,
    simulated,
)

BODIES: Mapping[str, Mapping[str, Any]] = {
    "com_offset": {"com": (0.3, -0.2)},
    "mass_spread": {"inertia_factor": 1.6},
    "mass_change": {"load": (1.2, 8.0)},
}
"""Changes of the body by a law, as an argument of `integrated`."""


@pytest.fixture(scope="module")
def bare() -> Floats:
    """Return the poses of the table without an effect."""
    return integrated([WHEEL], PUSH, 1e-3)


SMOOTH = (5e-7, 8e-7)
"""Tolerance, m and rad, where forces change no faster than the table moves; measured 0.23 µm, 0.32 µrad."""
ROUGH = {
    # The transitions between sticking and sliding depend on the step:
    # 30 and 83 µm, a fine one leaves 6 and 10.
    "coulomb_friction": (1e-4, 5e-5),
    "support_friction": (2e-4, 2e-4),
    # Dry friction along each of two axes: 55 and 58 µm, 123 and 44 µrad at a step of 1 ms.
    "axis_friction": (1e-4, 2e-4),
    "body_axis_friction": (1e-4, 1e-4),
    # A contact with a millimetre of give and dry friction along the rim: 3 µm and 6 µrad.
    "obstacle_contact": (1e-5, 2e-5),
}
FINE = {"coulomb_friction": 2e-4, "support_friction": 2e-4, "obstacle_contact": 2e-4}
"""Step of MuJoCo, s, where 1 ms would be unstable or too coarse for its rule."""


@pytest.mark.parametrize("kind", STATELESS)
def test_mujoco_integrates_the_laws_to_the_same_trajectory(kind: str, tmp_path: Path, bare: Floats) -> None:
    effects = [WHEEL, effect_of(kind)]
    world = poses(simulated(tmp_path, effects, PUSH))
    reference = integrated(effects, PUSH, FINE.get(kind, 1e-3), **BODIES.get(kind, {}))
    assert_alike(world, reference, ROUGH.get(kind, SMOOTH))
    assert gap(world, bare)[0] > 0.02, "give it values in VALUES with which it shows"


EXPORTED = (5e-6, 7e-6)
"""Tolerance, m and rad, to the export at 1 ms and half of it, extrapolated to none; measured 2 µm, 3 µrad."""
COARSE = {
    # What that leaves of MuJoCo's step: measured 4, 360, 14, 11 and 2 µm, 2, 340, 22, 38 and 12 µrad; most
    # where each of four feet with dry friction starts to slide at a different time.
    "coulomb_friction": (1e-4, 5e-5),
    "support_friction": (1e-3, 1e-3),
    "axis_friction": (2e-4, 1e-4),
    "body_axis_friction": (2e-4, 1e-4),
    "cogging": (4e-5, 6e-5),
    "obstacle_contact": (3e-5, 1e-4),
    "caster_swivel": (5e-6, 4e-5),
}


@pytest.mark.parametrize("kind", ON_OBJECT)
def test_the_export_follows_the_same_trajectory(kind: str, tmp_path: Path, bare: Floats) -> None:
    effects = [WHEEL, effect_of(kind)]
    world = poses(simulated(tmp_path, effects, PUSH))
    inner = [caster_angle(effects, world)] if kind == "caster_swivel" else None
    once, twice = (exported(tmp_path, effects, PUSH, step, inner=inner) for step in (1e-3, 5e-4))
    assert_alike(world, 2.0 * twice - once, COARSE.get(kind, EXPORTED))
    # At 1 ms by itself, with positions that lag by half a step: 0.4 to 1.6 mm.
    assert gap(world, once)[0] < 3e-3
    assert gap(world, bare)[0] > 0.02, "give it values in VALUES with which it shows"


def caster_angle(effects: list[Effect], world: Floats) -> float:
    """Return how the caster stood at first, by the first second: the simulation draws it untold."""
    t = np.arange(0.0, 1.0 + 5e-4, 1e-3)
    seen, described, wrench = world[round(CONTACT * 100) :][:101], model(effects), PUSH.on_origin(t)

    def off(angle: float) -> float:
        found, _ = described.rollout(PUSH.start, (0.0, 0.0, 0.0), t, wrench, contact=0.0, inner=[angle])
        return float(np.sum((found[::10] - seen) ** 2))

    first = min(np.linspace(-math.pi, math.pi, 64), key=off)
    near = minimize_scalar(off, bounds=(first - 0.1, first + 0.1), method="bounded", options={"xatol": 1e-9})
    return float(near.x)


def biased(t: Floats) -> Floats:
    """An offset, and its drift."""
    return PUSH.wrench(t) + np.column_stack([3.0 + 0.5 * t, -2.0 - 0.3 * t, 0.8 + 0.0 * t])


def heavier(t: Floats) -> Floats:
    """1 kg at the grasp, which is where MuJoCo says that it is."""
    step = 1e-3
    track = integrated([WHEEL], PUSH, step, rate=1.0 / step)
    x, y, angle = PUSH.grasp
    cos, sin = np.cos(track[:, 2]), np.sin(track[:, 2])
    held = track[:, :2] + np.column_stack([cos * x - sin * y, sin * x + cos * y])
    accel = np.zeros_like(held)
    accel[1:-1] = (held[2:] - 2.0 * held[1:-1] + held[:-2]) / step**2
    cos, sin = np.cos(track[:, 2] + angle), np.sin(track[:, 2] + angle)
    own = np.column_stack([cos, sin]), np.column_stack([-sin, cos])
    along, across = (np.sum(accel * axis, axis=1) for axis in own)
    felt = np.column_stack([along, across, 0.0 * along])[np.rint((t + CONTACT) / step).astype(int)]
    return np.asarray(PUSH.wrench(t) + felt)


def inverse(correct: Callable[[Floats, float], Floats], scales: tuple[float, float, float]) -> Any:
    """Return the reading of a load, by axis, where the load of a reading is `correct(reading, scale)`."""
    grid = np.linspace(-100.0, 100.0, 400_001)

    def read(t: Floats) -> Floats:
        loads = zip(PUSH.wrench(t).T, scales, strict=True)
        axes = [np.interp(load, correct(grid, scale), grid) for load, scale in loads]
        return np.column_stack(axes)

    return read


def saturated(reading: Floats, limit: float) -> Floats:
    """Return the load, of which 0.4 of the limit is missing at the limit and beyond."""
    high = np.minimum(np.abs(reading / limit), 2.0) ** 32
    return np.asarray(reading * (1.0 + 0.4 * high / (1.0 + high)))


def beyond_band(reading: Floats, band: float) -> Floats:
    """Return the load of what a sensor with a dead band reads."""
    return np.asarray(reading + band * reading / np.hypot(reading, 0.2 * band))


def rate(t: Floats) -> Floats:
    """Return how fast the push changes, 1/s; not a number at its knots, where that jumps."""
    found = (PUSH.wrench(t) - PUSH.wrench(t - STEP)) / STEP
    knots = np.array([knot[0] for knot in PUSH.knots])
    found[np.min(np.abs(t[:, None] - knots), axis=1) < 3.0 * STEP] = np.nan
    return np.asarray(found)


def playing(t: Floats) -> Floats:
    """A play of 4 N and 0.4 N·m."""
    width = np.array([4.0, 4.0, 0.4])
    return np.asarray(PUSH.wrench(t) - width / 2.0 * rate(t) / np.hypot(rate(t), 2.0 * width))


def lagging(t: Floats) -> Floats:
    """A lag of 50 ms, by steps of 0.1 ms."""
    fine = np.arange(0.0, t[-1] + 1e-4, 1e-4)
    loads, share = PUSH.wrench(fine + 5e-5), -math.expm1(-1e-4 / 0.05)
    followed = np.zeros_like(loads)
    for k in range(1, len(fine)):
        followed[k] = followed[k - 1] + share * (loads[k - 1] - followed[k - 1])
    return np.column_stack([np.interp(t, fine, column) for column in followed.T])


MIXED = np.array([[1.0, 0.2, 0.5], [-0.1, 1.0, 0.3], [0.05, -0.1, 1.0]])

READ: Mapping[str, Callable[[Floats], Floats]] = {
    "force_bias": biased,
    "gripper_inertia": heavier,
    "force_scale": lambda t: PUSH.wrench(t) * np.array([1.1, 0.8, 1.3]),
    "latency": lambda t: PUSH.wrench(t - 0.03),
    "tracker_offset": PUSH.wrench,
    "cross_talk": lambda t: PUSH.wrench(t) @ MIXED.T,
    "saturation": inverse(saturated, (30.0, 30.0, 5.0)),
    "dead_band": inverse(beyond_band, (3.0, 3.0, 0.3)),
    "sensor_play": playing,
    "clock_drift": lambda t: PUSH.wrench(t / 1.03),
    "sensor_lag": lagging,
    "drive_lag": lambda t: PUSH.wrench(t) + 0.03 * rate(t),
}
"""What the sensor reads at times since contact, gripper axes, N, N, N·m: a formula for each such effect."""


@pytest.mark.parametrize("kind", ON_INSTRUMENTS)
def test_instruments_read_a_formula_of_the_true_wrench(kind: str, tmp_path: Path, bare: Floats) -> None:
    columns = simulated(tmp_path, [WHEEL, effect_of(kind)], PUSH)
    seen = bare.copy()
    if kind == "tracker_offset":
        cos, sin = np.cos(bare[:, 2]), np.sin(bare[:, 2])
        seen += np.column_stack([0.1 * cos + 0.05 * sin, 0.1 * sin - 0.05 * cos, np.full(len(bare), 0.3)])
    assert_alike(poses(columns), seen, SMOOTH)
    t = columns["t"] - CONTACT
    pushed = (t > 0.005) & (t < PUSH.seconds - 0.005)
    reading = np.column_stack([columns[name] for name in ("force_x", "force_y", "torque_z")])[pushed]
    # The sensor gives the mean over the steps before and after, which at a knot is off by some of the slope.
    assert np.nanmax(np.abs(reading - READ[kind](t[pushed]))) < 200.0 * STEP
