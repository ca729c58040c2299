"""Measure simulated motions of a mechanism, and write them as a recording of joints."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path
from types import SimpleNamespace

import numpy as np

from trundle.atomic import write_text
from trundle.experiments.blind.mechanism.family import HiddenEffect
from trundle.experiments.blind.mechanism.scene import TIME_STEP, Scene
from trundle.experiments.blind.mechanism.simulation import Motion
from trundle.experiments.sampling import Floats

__all__ = ["record"]

MEASURING_STREAM = 77


def record(
    scene: Scene,
    hidden: Sequence[HiddenEffect],
    motions: Sequence[Motion],
    effort_rms: Floats,
    seed: int,
    folder: Path,
) -> None:
    """Write a recording. The noise depends on the seed only, not on the effects."""
    folder.mkdir(parents=True, exist_ok=True)
    write_text(folder / "robot.xml", scene.robot.text)
    for k, motion in enumerate(motions):
        rng = np.random.default_rng([seed, MEASURING_STREAM, k])
        columns = measure(rng, scene, hidden, motion, effort_rms)
        lines = [
            ",".join(columns),
            *(",".join(map(repr, row)) for row in zip(*columns.values(), strict=True)),
        ]
        write_text(folder / f"episode_{k:02}.csv", "\n".join(lines) + "\n")
    write_text(folder / "recording.toml", settings(scene, folder.name, effort_rms))


def measure(
    rng: np.random.Generator, scene: Scene, hidden: Sequence[HiddenEffect], motion: Motion, effort_rms: Floats
) -> dict[str, list[float]]:
    """Return the columns of an episode."""
    instrument, joints = scene.instrument, scene.robot.joints
    effort = motion.command if scene.source == "commanded" else motion.effort
    position = motion.drive if instrument["side"] == "drive" else motion.q
    seen = SimpleNamespace(t=motion.t, q=position.copy(), effort=effort.copy())
    for one in hidden:
        if one.family.distort is not None:
            one.family.distort(one.values, seen)
    rows = slice(None, None, round(1.0 / scene.rate / TIME_STEP))
    q, u = seen.q[rows], seen.effort[rows]
    noise, step = (
        np.array([instrument[key][joint] for joint in joints]) for key in ("position_noise", "position_step")
    )
    q = q + noise * rng.standard_normal(q.shape)
    q = np.where(step > 0.0, np.round(q / np.where(step > 0.0, step, 1.0)) * step, q)
    if scene.source in ("measured", "current"):
        u = u + instrument["effort_noise"] * effort_rms * rng.standard_normal(u.shape)
    columns = {"t": np.round(motion.t[rows], 6).tolist()}
    for j, joint in enumerate(joints):
        columns[f"q_{joint}"] = q[:, j].tolist()
        if scene.source == "target":
            columns[f"target_{joint}"] = motion.target[rows, j].tolist()
        else:
            gain = instrument["gain"] if scene.source == "current" else 1.0
            columns[f"effort_{joint}"] = (u[:, j] / gain).tolist()
    return columns


def settings(scene: Scene, name: str, effort_rms: Floats) -> str:
    """Return the text of `recording.toml`."""
    instrument, joints = scene.instrument, scene.robot.joints
    free = [f"mass:{body}" for body in scene.robot.bodies]
    free += [f"{kind}:{joint}" for kind in ("armature", "damping") for joint in joints]
    free = [one for one in free if one not in scene.fixed]
    held = [
        f"episode_{k:02}"
        for k in range(len(scene.payloads) - (2 if len(scene.payloads) > 4 else 1), len(scene.payloads))
    ]
    lines = [
        'format = "trundle-recording/2"',
        f'name = "{name}"',
        "[mechanism]",
        'model = "robot.xml"',
        f"joints = {json.dumps(joints)}",
        f"free = {json.dumps(free)}",
    ]
    if scene.source == "target":
        kp, kd = scene.gains()
        values = {"stiffness": kp, "damping": kd}
        lines.append("[target]")
        for key, value in values.items():
            table = ", ".join(f"{joint} = {one!r}" for joint, one in zip(joints, value.tolist(), strict=True))
            lines.append(f'{key} = "free"' if instrument["stiffness_free"] else f"{key} = {{{table}}}")
    else:
        lines += ["[effort]", f'source = "{scene.source}"']
        if scene.source == "current":
            lines.append(f"gain = {instrument['gain']!r}")
    lines += ["[encoder]", f'side = "{instrument["side"]}"']
    if instrument["noise_given"]:
        lines += ["[noise]", *noise_lines(scene, effort_rms)]
    lines += ["[split]", f"held_out = {json.dumps(held)}"]
    place = "{body = %s, mass = %r, com = [0.0, 0.0, 0.0]}"
    for k, mass in enumerate(scene.payloads):
        if mass is not None:
            lines += [f"[episode.episode_{k:02}]", f"payload = {place % (json.dumps(scene.last_body), mass)}"]
    return "\n".join(lines) + "\n"


def noise_lines(scene: Scene, effort_rms: Floats) -> list[str]:
    """Return the entries of `[noise]`: standard deviations with quantisation, and steps."""
    instrument, joints = scene.instrument, scene.robot.joints
    noise, step = instrument["position_noise"], instrument["position_step"]
    tables = {"position": {joint: float(np.hypot(noise[joint], step[joint] / 12**0.5)) for joint in joints}}
    if any(step.values()):
        tables["position_step"] = step
    if scene.source in ("measured", "current"):
        gain = instrument["gain"] if scene.source == "current" else 1.0
        share = instrument["effort_noise"] / gain
        tables["effort"] = {joint: float(share * one) for joint, one in zip(joints, effort_rms, strict=True)}
    text = {
        key: ", ".join(f"{joint} = {one!r}" for joint, one in table.items()) for key, table in tables.items()
    }
    return [f"{key} = {{{table}}}" for key, table in text.items()]
