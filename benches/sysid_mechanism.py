"""MuJoCo's system identification toolbox on recordings of joints, compared with trundle's diagnosis.

pip install "mujoco[sysid]"
python benches/sysid_mechanism.py --recordings DIR [--limit 10]

DIR contains recordings with an MJCF model: those of the blind benchmark, or your own. The toolbox is used as
in its examples: motors apply the recorded efforts, and the masses of all bodies, and armature, damping and
dry friction of all joints are fitted to the positions by simulation. Each training episode is divided into
windows that begin with a measured state, because errors grow in open loop. Recordings without a known effort
are skipped. All figures are trundle's, computed with either model on the held-out episodes.
"""

from __future__ import annotations

import argparse
import contextlib
import io
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter
from typing import Any

import mujoco
import numpy as np
from mujoco import sysid
from numpy.typing import NDArray

import trundle
from trundle import _native
from trundle.joint_diagnosis.mechanisms import model_folder
from trundle.joint_diagnosis.signals import read_signals, setting

Array = NDArray[np.float64]

WINDOW_S = 1.0
"""Length of a window, s."""
MAX_WINDOWS = 16
"""Windows of the fit, evenly distributed over the training episodes."""
MAX_ITERATIONS = 30
ROUNDING = {"xtol": 1e-15, "gtol": 1e-15, "eps": 1e-6}
"""With its default tolerances the toolbox stops at the start."""
MASS_RANGE = (0.5, 2.0)
"""Bounds of a mass, as a share of the model's."""
JOINT_RANGES = {"armature": 10.0, "damping": 10.0, "frictionloss": 3.0}
"""Upper bounds: multiples of the model's value, or of the effort that the motion needs."""
FIGURE = "relative_window_rmse"
"""Figure of the table: error of positions within a second, as a share of the joints' ranges."""


@dataclass(frozen=True)
class Fitted:
    """What the toolbox reports.

    Attributes
    ----------
    xml : str
        The fitted model.
    values, intervals : dict of str to float
        By parameter: value and half of the 95 % interval.
    insights : list of str
        "Automated insights" of its report.
    seconds : float
    """

    xml: str
    values: dict[str, float]
    intervals: dict[str, float]
    insights: list[str]
    seconds: float


def skipped(recording: trundle.JointRecording) -> str | None:
    """Return why the toolbox cannot use a recording."""
    if "model" not in recording.metadata["mechanism"]:
        return "no model"
    if any("model" in table for table in recording.metadata.get("episode", {}).values()):
        return "several models"
    for joint in recording.joints:
        for name in recording:
            if f"effort_{joint}" not in recording[name]:
                return "no effort"
            if setting(recording.metadata, name, "effort", "gain", joint, 1.0) == "free":
                return "unknown gain"
    return None


def prepared(text: str, joints: list[str]) -> Any:
    """Return a model with a motor and a position sensor for each recorded joint, and no other actuator."""
    spec = mujoco.MjSpec.from_string(text)
    for element in [*spec.actuators, *spec.sensors, *spec.keys]:
        spec.delete(element)
    for joint in joints:
        motor = spec.add_actuator(name=f"{joint}_motor", target=joint, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.gear = [1.0, 0.0, 0.0, 0.0, 0.0, 0.0]
        spec.add_sensor(
            name=f"{joint}_position",
            objname=joint,
            objtype=mujoco.mjtObj.mjOBJ_JOINT,
            type=mujoco.mjtSensor.mjSENS_JOINTPOS,
        )
    spec.option.timestep = min(spec.option.timestep, 0.002)
    spec.option.integrator = mujoco.mjtIntegrator.mjINT_IMPLICITFAST
    return spec


def with_payload(spec: Any, payload: dict[str, Any] | None) -> Any:
    """Return a copy of a model with the payload of an episode."""
    own = spec.copy()
    if payload is not None:
        body = own.body(payload["body"]).add_body(name="payload", pos=payload.get("com", [0.0, 0.0, 0.0]))
        body.mass, body.inertia, body.explicitinertial = payload["mass"], [1e-8] * 3, True
    return own


def sequences(recording: trundle.JointRecording, spec: Any) -> list[Any]:
    """Return the windows of the training episodes for the toolbox."""
    motion = _native._joint_motion(recording)
    training = [name for name in recording if not recording[name].held_out]
    each = max(1, MAX_WINDOWS // len(training))
    found = []
    for name in training:
        own = motion["episodes"][name]
        signals = [read_signals(recording, name, joint, own["t"]) for joint in recording.joints]
        gains = [float(one.gain) for one in signals]
        effort = np.stack(
            [one.command * gain * one.on + one.known for one, gain in zip(signals, gains, strict=True)], 1
        )
        seen = np.stack([one.raw for one in signals], axis=1)
        payload = recording.metadata.get("episode", {}).get(name, {}).get("payload")
        model = with_payload(spec, payload)
        compiled = model.compile()
        size = max(8, round(WINDOW_S / (own["t"][1] - own["t"][0])))
        inner = np.flatnonzero(own["a"].any(axis=1))
        starts = np.unique(np.linspace(inner[0], max(inner[0], inner[-1] - size), each).astype(int))
        for start in starts:
            rows = slice(start, start + size)
            t = own["t"][rows] - own["t"][start]
            place = [compiled.joint(joint).qposadr[0] for joint in recording.joints]
            q, v = compiled.qpos0.copy(), np.zeros(compiled.nv)
            q[place], v[place] = own["q"][start], own["v"][start]
            state = sysid.create_initial_state(compiled, q, v, np.zeros(0))
            found.append(
                sysid.ModelSequences(
                    name,
                    model,
                    f"{name}_{start}",
                    state,
                    sysid.TimeSeries(t, effort[rows]),
                    sysid.TimeSeries.from_names(t, seen[rows], compiled),
                )
            )
    return found


def parameters(recording: trundle.JointRecording, spec: Any, efforts: Array) -> Any:
    """Return mass, armature, damping and dry friction as parameters of the toolbox."""
    model = spec.compile()
    found = sysid.ParameterDict()

    def add(name: str, value: float, low: float, high: float, modifier: Any) -> None:
        found.add(sysid.Parameter(name, value, low, high, modifier=modifier))

    for k in range(1, model.nbody):
        if model.body_weldid[k] != 0 and model.body_mass[k] > 0:
            body, mass = model.body(k).name, float(model.body_mass[k])
            inertia = np.array(model.body_inertia[k]) / mass

            def set_mass(own: Any, p: Any, body: str = body, inertia: Array = inertia) -> None:
                own.body(body).mass, own.body(body).inertia = p.value[0], p.value[0] * inertia

            add(f"mass:{body}", mass, MASS_RANGE[0] * mass, MASS_RANGE[1] * mass, set_mass)
    for joint, effort in zip(recording.joints, efforts, strict=True):
        for key, factor in JOINT_RANGES.items():
            dof = model.joint(joint).dofadr[0]
            value = float(getattr(model, f"dof_{key}")[dof])
            high = factor * max(value, 0.1 * effort)
            if key == "frictionloss":
                high = factor * effort

            def set_joint(own: Any, p: Any, joint: str = joint, key: str = key) -> None:
                if key == "damping":
                    own.joint(joint).damping = [p.value[0], 0.0, 0.0]
                else:
                    setattr(own.joint(joint), key, p.value[0])

            # A start at the bound stalls, and dry friction begins at a hundredth of the effort.
            add(
                f"{key}:{joint}",
                max(value, 0.01 * effort if key == "frictionloss" else value),
                0.0,
                high,
                set_joint,
            )
    return found


def fit(recording: trundle.JointRecording, text: str) -> Fitted:
    """Fit a recording with the toolbox."""
    begin = perf_counter()
    spec = prepared(text, recording.joints)
    windows = sequences(recording, spec)
    efforts = np.sqrt(np.mean(np.concatenate([one.control[0].data for one in windows]) ** 2, axis=0))
    start = parameters(recording, spec, efforts)
    residual = sysid.build_residual_fn(models_sequences=windows)
    with contextlib.redirect_stdout(io.StringIO()):
        found, result = sysid.optimize(
            start, residual, "mujoco", verbose=False, max_iters=MAX_ITERATIONS, **ROUNDING
        )
        residuals, _, _ = residual(found.as_vector(), found)
    _, intervals = sysid.calculate_intervals(residuals, np.asarray(result.jac))
    from mujoco.sysid.report.sections.insights import AutomatedInsights

    insights = AutomatedInsights("", found).get_context()["insights"]
    fitted = mujoco.MjSpec.from_string(text)
    sysid.apply_param_modifiers_spec(found, fitted)
    fitted.compile()
    names = found.get_non_frozen_parameter_names()
    return Fitted(
        fitted.to_xml(),
        dict(zip(names, found.as_vector().tolist(), strict=True)),
        dict(zip(names, np.asarray(intervals).ravel().tolist(), strict=True)),
        [re.sub(r"<[^>]+>", "", f"{one['title']}: {one['message']}") for one in insights],
        perf_counter() - begin,
    )


def figures(recording: trundle.JointRecording, xml: str) -> dict[str, Any]:
    """Return trundle's held-out figures of a model whose values stay as they are."""
    metadata = {**recording.metadata, "mechanism": {**recording.metadata["mechanism"], "free": []}}
    episodes = {name: dict(recording[name]) for name in recording}
    model = metadata["mechanism"]["model"]
    fixed = trundle.JointRecording(metadata, episodes, {**recording.files, model: xml.encode()})
    effects = sorted({one["effect"] for one in _native._joint_effects()})
    answer = trundle.diagnose(fixed, without=effects, check=False, progress=False).answer
    pair = answer["fit"]["held_out"]
    assert pair is not None
    return pair["before"]


def compared(folder: Path) -> Iterator[str]:
    """Yield the lines of a recording."""
    recording = trundle.read(folder)
    if not isinstance(recording, trundle.JointRecording):
        return
    reason = skipped(recording)
    if reason is not None:
        yield f"{folder.name}: skipped, {reason}"
        return
    with model_folder(recording) as files:
        path = files / recording.metadata["mechanism"]["model"]
        text = mujoco.MjSpec.from_file(str(path)).to_xml()
    begin = perf_counter()
    ours = trundle.diagnose(recording, check=False, progress=False)
    seconds = perf_counter() - begin
    peer = fit(recording, text)
    held_out = ours.answer["fit"]["held_out"]
    if held_out is None:
        yield f"{folder.name}: skipped, no held-out episode"
        return
    shown = {
        "model as given": figures(recording, text),
        "toolbox": figures(recording, peer.xml),
        "trundle, refitted": held_out["before"],
        "trundle, diagnosed": held_out["after"],
    }
    row = "  ".join(f"{name} {_number(one[FIGURE])}" for name, one in shown.items())
    yield f"{folder.name}: held-out {FIGURE}: {row}"
    yield f"  trundle ({seconds:.0f} s): {ours.verdict}: {', '.join(ours.missing) or 'nothing'}"
    yield f"  toolbox ({peer.seconds:.0f} s): {' '.join(peer.insights)}"
    for name, value in peer.values.items():
        yield f"    {name:32} {value:12.5g} ± {peer.intervals[name]:.2g}"


def _number(value: float | None) -> str:
    return "–" if value is None else f"{value:.4f}"


def main() -> None:
    parser = argparse.ArgumentParser(
        description="Compare trundle with MuJoCo's toolbox on recordings of joints."
    )
    parser.add_argument("--recordings", type=Path, required=True, help="folder of recordings")
    parser.add_argument("--limit", type=int, default=10, help="largest number of recordings (default 10)")
    options = parser.parse_args()
    if not hasattr(sysid, "optimize"):
        parser.exit(1, 'the toolbox is incomplete: pip install "mujoco[sysid]"\n')
    folders = sorted(path.parent for path in options.recordings.rglob("recording.toml"))
    for folder in folders[: options.limit]:
        for line in compared(folder):
            print(line, flush=True)


if __name__ == "__main__":
    main()
