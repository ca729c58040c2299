"""Fit of six parameters to one push: trundle compared with MuJoCo's system identification toolbox.

pip install "mujoco[sysid]"
python benches/sysid.py

The parameters are the mass of a table, and position, angle and two friction coefficients of its wheel. The
table is pushed for five seconds and recorded at 100 Hz. Both programs have the same recording and the same
starts. The bounds are the range of the starts and the footprint. Finally, the memory of a fit is measured for
recordings that are 1, 4 and 16 times as long.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from collections.abc import Callable
from contextlib import redirect_stdout
from pathlib import Path
from time import perf_counter, process_time
from typing import Any, NamedTuple

import mujoco
import numpy as np
from mujoco import sysid
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

import trundle

Array = NDArray[np.float64]

NAMES = ("body.mass", *(f"viscous_wheel.{key}" for key in ("x", "y", "angle", "mu_x", "mu_y")))
TRUTH = np.array([22.0, -0.5, -0.3, 0.2, 15.0, 180.0])
START = np.array([12.0, 0.1, 0.1, 0.6, 30.0, 60.0])
LOWER = np.array([2.0, -0.6, -0.4, -np.pi / 2, 1.0, 1.0])
UPPER = np.array([100.0, 0.6, 0.4, np.pi / 2, 1000.0, 1000.0])
POSITIVE = np.array([True, False, False, False, True, True])
"""Parameters whose logarithm is drawn and, in the toolbox, searched."""
TOLERANCES = np.array([0.05, 0.01, 0.01, 0.03, 0.1, 0.1])
"""Largest distance from the optimum of a successful search: relative (mass, friction), or in m and rad."""

SIDES = (1.2, 0.8)
GYRATION = float(np.hypot(*SIDES) / np.sqrt(12.0))
FOOTPRINT = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]
NOISE = {"pose": [5e-4, 5e-4, 1.7e-3], "force": 0.4, "torque": 0.05}
RATE, DURATION, CONTACT = 100.0, 5.0, 0.2


class Data(NamedTuple):
    """A recording: times (n,), wrenches (n, 3; object axes, about the origin), poses (n, 3; world)."""

    t: Array
    wrench: Array
    pose: Array


def push(t: Any) -> Array:
    """Return the wrench of the push, object axes about the object origin; shape (..., 3)."""
    on = np.clip((t - CONTACT) / 0.1, 0.0, 1.0)
    waves = (8 + 20 * np.sin(2.2 * t + 0.4), 14 * np.sin(3.1 * t), 4 * np.sin(1.7 * t + 1.0))
    return np.stack([on * wave for wave in waves], axis=-1)


def motion(t: float, state: Array, parameters: Array) -> Array:
    """Return the derivative of pose and twist under the push (eq. 1-3)."""
    mass, x, y, angle, *mu = parameters
    theta, velocity, spin = state[2], state[3:5], state[5]
    turn = np.array([[np.cos(theta), -np.sin(theta)], [np.sin(theta), np.cos(theta)]])
    rolling = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    slip = turn.T @ velocity + spin * np.array([-y, x])
    friction = -rolling @ np.diag(mu) @ rolling.T @ slip
    wrench = push(t) + np.append(friction, x * friction[1] - y * friction[0])
    return np.concatenate([state[3:], turn @ wrench[:2] / mass, wrench[2:] / (mass * GYRATION**2)])


def record(seed: int, duration: float = DURATION) -> Data:
    """Simulate the recording, with noise of sensor and tracker."""
    rng = np.random.default_rng(seed)
    t = np.arange(0.0, duration + 0.5 / RATE, 1.0 / RATE)
    solved = solve_ivp(motion, (0.0, t[-1]), np.zeros(6), "LSODA", t, args=(TRUTH,), rtol=1e-9, atol=1e-10)
    wrench = push(t) + rng.normal(size=(len(t), 3)) * [NOISE["force"], NOISE["force"], NOISE["torque"]]
    return Data(t, wrench, solved.y[:3].T + rng.normal(size=(len(t), 3)) * NOISE["pose"])


Search = Callable[[Array], Array]
"""A search: from a start to its end."""


def recording(data: Data) -> trundle.Recording:
    """Return the data as a recording."""
    metadata = {
        "format": "trundle-recording/1",
        "name": "table",
        "object": {"footprint": FOOTPRINT},
        "wrench": {"frame": "object", "reference": "object", "sign": "on_object", "raw": False},
        "noise": NOISE,
    }
    columns = dict(zip(("object_x", "object_y", "object_theta"), data.pose.T, strict=True))
    columns |= dict(zip(("force_x", "force_y", "torque_z"), data.wrench.T, strict=True))
    return trundle.Recording(metadata, {"push": {"t": data.t, **columns}})


XML = """
<mujoco>
  <compiler angle="radian"/>
  <option integrator="implicitfast" timestep="0.002" gravity="0 0 0"><flag contact="disable"/></option>
  <worldbody>
    <body name="table">
      <inertial pos="0 0 0" mass="1" diaginertia="1 1 1"/>
      <joint name="x" type="slide" axis="1 0 0"/>
      <joint name="y" type="slide" axis="0 1 0"/>
      <joint name="theta" type="hinge" axis="0 0 1"/>
      <site name="origin"/>
      <site name="wheel"/>
    </body>
  </worldbody>
  <actuator>
    <motor site="origin" gear="1 0 0 0 0 0"/>
    <motor site="origin" gear="0 1 0 0 0 0"/>
    <motor site="origin" gear="0 0 0 0 0 1"/>
    <general name="along" site="wheel" gear="1 0 0 0 0 0" gainprm="0" biastype="affine"/>
    <general name="across" site="wheel" gear="0 1 0 0 0 0" gainprm="0" biastype="affine"/>
  </actuator>
  <sensor>
    <jointpos name="sx" joint="x"/><jointpos name="sy" joint="y"/><jointpos name="stheta" joint="theta"/>
  </sensor>
</mujoco>
"""
"""The same law: actuators whose force is minus a coefficient times the velocity of their site."""


def to_search(parameters: Array) -> Array:
    """Return the coordinates that the toolbox searches."""
    return np.where(POSITIVE, np.log(np.abs(parameters)), parameters)


def from_search(searched: Array) -> Array:
    """Return the parameters from the coordinates that the toolbox searches."""
    return np.where(POSITIVE, np.exp(np.where(POSITIVE, searched, 0.0)), searched)


def apply(spec: Any, parameter: Any) -> None:
    """Set the parameters of MuJoCo's model."""
    mass, x, y, angle, mu_x, mu_y = from_search(parameter.value)
    table, wheel = spec.body("table"), spec.site("wheel")
    table.mass = mass
    table.inertia = [mass, mass, mass * GYRATION**2]
    wheel.pos = [x, y, 0.0]
    wheel.quat = [np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2)]
    spec.actuator("along").biasprm[2] = -mu_x
    spec.actuator("across").biasprm[2] = -mu_y


def toolbox_search(data: Data) -> Search:
    """Return the search of MuJoCo's toolbox. With its default tolerances it stops at the start."""
    spec = mujoco.MjSpec.from_string(XML)
    model = spec.compile()
    state = sysid.create_initial_state(model, data.pose[0] * 0.0, np.zeros(3), np.zeros(0))
    control = sysid.TimeSeries(data.t, np.column_stack([data.wrench, np.zeros((len(data.t), 2))]))
    seen = sysid.TimeSeries.from_names(data.t, data.pose, model)
    sequences = sysid.ModelSequences("table", spec, "push", state, control, seen)
    residual = sysid.build_residual_fn(models_sequences=[sequences])

    def search(start: Array) -> Array:
        parameters = sysid.ParameterDict()
        # The angle needs no bounds.
        around = np.where(np.arange(len(TRUTH)) == NAMES.index("viscous_wheel.angle"), 2 * np.pi, 0.0)
        bounds = to_search(LOWER) - around, to_search(UPPER) + around
        parameters.add(sysid.Parameter("all", to_search(start), *bounds, modifier=apply))
        with open(os.devnull, "w") as nowhere, redirect_stdout(nowhere):
            found, _ = sysid.optimize(
                parameters, residual, "mujoco", verbose=False, xtol=1e-15, gtol=1e-15, eps=1e-6
            )
        return from_search(found["all"].value)

    return search


def trundle_search(data: Data) -> Search:
    """Return the search of trundle."""
    source = recording(data)

    def search(start: Array) -> Array:
        found = trundle.fit(source, start=dict(zip(NAMES, start.tolist(), strict=True)), starts=0)
        values = {each["name"]: each["value"] for each in found.model.parameters}
        return np.array([values[name] for name in NAMES])

    return search


def canonical(parameters: Array) -> Array:
    """Exchange the axes so that "along" has the least friction: a wheel rotated by 90° is the same wheel."""
    mass, x, y, angle, mu_x, mu_y = parameters
    if mu_x > mu_y:
        angle, mu_x, mu_y = angle + np.pi / 2, mu_y, mu_x
    return np.array([mass, x, y, (angle + np.pi / 2) % np.pi - np.pi / 2, mu_x, mu_y])


def is_optimal(found: Array, optimum: Array) -> bool:
    """Return whether a search reached the optimum."""
    off = np.abs(canonical(found) - canonical(optimum))
    off[3] = min(off[3], np.pi - off[3])
    return bool(np.all(off / np.where(POSITIVE, canonical(optimum), 1.0) < TOLERANCES))


def draw(rng: np.random.Generator) -> Array:
    """Draw a start: uniform within the bounds, log-uniform for positive parameters."""
    return from_search(rng.uniform(to_search(LOWER), to_search(UPPER)))


def timed_search(search: Search, start: Array) -> tuple[Array, float, float]:
    """Return the end of a search, and its wall and CPU time, s."""
    wall, cpu = perf_counter(), process_time()
    found = search(start)
    return found, perf_counter() - wall, process_time() - cpu


def formatted(parameters: Array) -> str:
    """Return the parameters as text."""
    return "  ".join(f"{value:8.3f}" for value in canonical(parameters))


def compare(seed: int, starts: int, turns: int) -> None:
    """Print results, times, and the numbers of starts that reach the optimum."""
    data = record(seed)
    searches = {"trundle": trundle_search(data), "toolbox": toolbox_search(data)}
    print("end of a fixed start           mass         x         y     angle      mu_x      mu_y")
    print(f"{'truth':26}", formatted(TRUTH))
    times: dict[str, list[tuple[float, float]]] = {name: [] for name in searches}
    for _ in range(turns):
        for name, search in searches.items():
            for _ in range(5 if name == "trundle" else 1):
                found, *took = timed_search(search, START)
                times[name].append((took[0], took[1]))
            if len(times[name]) <= 5:
                print(f"{name:26}", formatted(found))
    best = {name: np.min(took, axis=0) for name, took in times.items()}
    for name, (wall, cpu) in best.items():
        print(f"{name}: {1e3 * wall:.1f} ms, {1e3 * cpu:.1f} ms CPU time")
    wall, cpu = best["toolbox"] / best["trundle"]
    print(f"the toolbox takes {wall:.0f} times the wall time and {cpu:.0f} times the CPU time")
    rng = np.random.default_rng(seed)
    drawn = [draw(rng) for _ in range(starts)]
    for name, search in searches.items():
        optimum = search(TRUTH)
        ends = [search(start) for start in drawn]
        misses = [formatted(end) for end in ends if not is_optimal(end, optimum)]
        print(
            f"{name}: {starts - len(misses)} of {starts} random starts reach the optimum", formatted(optimum)
        )
        for miss in misses:
            print(f"{'  ends at':26}", miss)


def status_mb(key: str) -> float:
    """Return an entry of the status of this process, MB (Linux)."""
    lines = Path("/proc/self/status").read_text(encoding="ascii").splitlines()
    return next(float(line.split()[1]) / 1024 for line in lines if line.startswith(key))


def fit_memory_mb(duration: float) -> float:
    """Return the increase of the peak memory by a fit, MB."""
    data = record(0, duration)
    Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
    before = status_mb("VmRSS")
    trundle_search(data)(START)
    return status_mb("VmHWM") - before


def print_memory() -> None:
    """Print the memory of a fit by the length of the recording, each measured in a separate process."""
    for times in (1, 4, 16):
        command = [sys.executable, __file__, "--resident", str(times * DURATION)]
        taken = float(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        samples = int(times * DURATION * RATE)
        print(f"{samples:6} samples: {taken:6.1f} MB, {1e3 * taken / samples:5.2f} kB per sample")


def main() -> None:
    parser = argparse.ArgumentParser(
        description="Compare trundle with MuJoCo's system identification toolbox."
    )
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--starts", type=int, default=10)
    parser.add_argument(
        "--turns", type=int, default=3, help="rounds of timed fits; the fastest counts (default 3)"
    )
    parser.add_argument("--resident", type=float, help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.resident:
        print(fit_memory_mb(options.resident))
        return
    if not hasattr(sysid, "optimize"):
        # Without the packages of the extra, the module imports but is empty.
        parser.exit(1, 'the toolbox is incomplete: pip install "mujoco[sysid]"\n')
    compare(options.seed, options.starts, options.turns)
    print_memory()


if __name__ == "__main__":
    main()
