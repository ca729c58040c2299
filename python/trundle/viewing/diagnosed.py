"""The scene of a diagnosis: its recording, both simulations, the missing wrench, and the windows."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from trundle._native import Laws, Model
from trundle.export.mjcf import parse_model
from trundle.inspection import smooth
from trundle.recording import Recording, TrundleError
from trundle.report import wording
from trundle.report.figures.wheels import known_wheels
from trundle.report.verdict import headline
from trundle.viewing.recorded import AXES, recorded_episodes
from trundle.viewing.scene import Arrow, Curve, Episode, Floats, Motion, Panel, Scene, Wheel, Window
from trundle.viewing.wrenches import added_laws, law_wrenches

__all__ = ["SIDES", "Diagnosed", "diagnosed_scene"]

SIDES = ("before", "after")
"""Simulations without and with the missing effects."""
WHEEL = "viscous_wheel"
MAX_POSE_ERROR = 1e-6
"""Largest difference between the poses of a diagnosis and those of its recording, m or rad."""


@dataclass(frozen=True)
class Diagnosed:
    """A diagnosis as its folder stores it.

    Attributes
    ----------
    answer : mapping
        The content of diagnosis.json.
    model : Model
        The extended model.
    poses : mapping of str to mapping of str to Motion
        For each simulated episode the motions "observed", "before" and "after"; the last two are absent if
        there is no open-loop simulation.
    residuals : mapping of str to mapping of str to (t, wrench)
        For each episode the missing wrench (n, 3) of the models "before" and "after", object axes about the
        object's origin, N, N, N·m. A folder does not store it; it is part of a `trundle.Diagnosis`.
    """

    answer: Mapping[str, Any]
    model: Model
    poses: Mapping[str, Mapping[str, Motion]]
    residuals: Mapping[str, Mapping[str, tuple[Floats, Floats]]] = field(default_factory=dict)


def diagnosed_scene(diagnosed: Diagnosed, recording: Recording) -> Scene:
    """Return the scene of a diagnosis, simulated episodes first.

    Raises
    ------
    TrundleError
        If the diagnosis is of another recording.
    """
    recorded = recorded_episodes(recording)
    check_recording(diagnosed, recording.name, recorded)
    wheels = {"before": before_wheels(diagnosed.answer), "after": after_wheels(diagnosed.model)}
    laws = added_laws(diagnosed.model, diagnosed.answer)
    points = effect_points(diagnosed.answer)
    motions = smooth(recording) if laws else {}
    episodes = []
    for index, each in enumerate(recorded):
        missing = missing_arrows(each, index, motions.get(each.name), laws, points)
        poses = diagnosed.poses.get(each.name, {})
        residual = diagnosed.residuals.get(each.name, {})
        if not laws and "before" in residual:
            missing = {"residual": residual_arrow(residual["before"], points)}
        episodes.append(
            replace(
                each,
                shape=replace(each.shape, wheels=wheels["after"], points=points),
                arrows={**each.arrows, **missing},
                models={side: (poses[side], wheels[side]) for side in SIDES if side in poses},
                panels=[
                    *simulated_panels(each, poses),
                    *missing_panels(each, missing),
                    *error_panels(poses),
                    *residual_panels(residual),
                ],
                windows=episode_windows(diagnosed.answer, each.name),
            )
        )
    shown = sorted(episodes, key=lambda episode: not episode.models)
    return Scene(recording.name, summary(diagnosed.answer), shown)


def check_recording(diagnosed: Diagnosed, name: str, episodes: Sequence[Episode]) -> None:
    """Refuse a recording with another name, other episodes or other poses than the diagnosed one."""
    expected = diagnosed.answer["recording"]
    if name != expected:
        raise TrundleError(f"the diagnosis is of the recording {expected!r}, not of {name!r}")
    motions = {episode.name: episode.motion for episode in episodes}
    for episode, poses in diagnosed.poses.items():
        observed, motion = poses["observed"], motions.get(episode)
        if motion is None:
            raise TrundleError(f"recording {name!r} has no {episode}, which the diagnosis simulates")
        same = observed.pose.shape == motion.pose.shape and np.allclose(
            observed.pose, motion.pose, rtol=0.0, atol=MAX_POSE_ERROR
        )
        if not same:
            raise TrundleError(
                f"recording {name!r}, {episode}: its poses differ from those in the diagnosis; "
                "give the diagnosed recording, or repeat the diagnosis"
            )


def before_wheels(answer: Mapping[str, Any]) -> list[Wheel]:
    """Return the identified wheels of the nominal model."""
    nominal = {**answer["nominal"], "after": None}
    return [Wheel(wheel.position, wheel.angle) for wheel in known_wheels(nominal)]


def after_wheels(model: Model) -> list[Wheel]:
    """Return the wheels of the extended model."""
    tables = [each for each in parse_model(model).get("effect", ()) if each["kind"] == WHEEL]
    return [Wheel(np.array([each["x"], each["y"]]), float(each.get("angle", 0.0))) for each in tables]


def effect_points(answer: Mapping[str, Any]) -> dict[str, Floats]:
    """Return where missing effects act on the object, m, object frame, by effect."""
    points = {}
    for effect in answer["missing"]:
        point = (effect.get("where") or {}).get("body_point")
        if point:
            points[str(effect["effect"])] = np.array(point["mean"], dtype=float)
    hint = answer["mismatch"].get("body_point")
    if answer["verdict"] == "unexplained" and hint:
        points["discrepancy"] = np.array(hint, dtype=float)
    return points


def missing_arrows(
    episode: Episode,
    index: int,
    motion: Mapping[str, Floats] | None,
    laws: Mapping[str, Laws],
    points: Mapping[str, Floats],
) -> dict[str, Arrow]:
    """Return the wrenches of the missing effects along the recorded motion of an episode."""
    if motion is None or not len(motion["t"]):
        return {}
    t, measured = motion["t"], episode.arrows["measured"]
    applied = np.column_stack([np.interp(t, measured.t, measured.wrench[:, k]) for k in range(3)])
    arrows = {}
    for name, law in laws.items():
        wrench = law_wrenches(law, motion, applied, episode.contact, index)
        point = np.tile(points.get(name, np.zeros(2)), (len(t), 1))
        arrows[name] = Arrow(t, point, wrench)
    return arrows


def simulated_panels(episode: Episode, poses: Mapping[str, Motion]) -> list[Panel]:
    """Return the plots of the pose with both simulations."""
    position, turn, *_ = episode.panels
    curves, turns = list(position.curves), list(turn.curves)
    for side in SIDES:
        if side in poses:
            t, pose = poses[side].t, poses[side].pose
            curves += [Curve(f"{axis} {side}", side, t, pose[:, k]) for k, axis in enumerate(AXES)]
            turns.append(Curve(side, side, t, pose[:, 2]))
    return [replace(position, curves=curves), replace(turn, curves=turns)]


def missing_panels(episode: Episode, missing: Mapping[str, Arrow]) -> list[Panel]:
    """Return the plots of the wrench with the wrenches of the missing effects."""
    force, torque = episode.panels[2:]
    forces, torques = list(force.curves), list(torque.curves)
    for name, arrow in missing.items():
        forces += [
            Curve(f"{axis} {wording.effect_name(name)}", "missing", arrow.t, arrow.wrench[:, k])
            for k, axis in enumerate(AXES)
        ]
        torques.append(Curve(wording.effect_name(name), "missing", arrow.t, arrow.wrench[:, 2]))
    return [replace(force, curves=forces), replace(torque, curves=torques)]


def error_panels(poses: Mapping[str, Motion]) -> list[Panel]:
    """Return the plots of the residual: simulated minus recorded pose."""
    distances, turns = [], []
    for side in SIDES:
        if side in poses:
            gap = poses[side].pose - poses["observed"].pose
            distances.append(Curve(side, side, poses[side].t, np.hypot(gap[:, 0], gap[:, 1])))
            turned = np.remainder(gap[:, 2] + np.pi, 2.0 * np.pi) - np.pi
            turns.append(Curve(side, side, poses[side].t, turned))
    if not distances:
        return []
    return [
        Panel("position_residual", "Position residual, m", distances),
        Panel("heading_residual", "Heading residual, rad", turns),
    ]


def residual_arrow(residual: tuple[Floats, Floats], points: Mapping[str, Floats]) -> Arrow:
    """Return the missing wrench of a model as an arrow where the diagnosis locates it."""
    t, wrench = residual
    return Arrow(t, np.tile(points.get("discrepancy", np.zeros(2)), (len(t), 1)), wrench)


def residual_panels(residual: Mapping[str, tuple[Floats, Floats]]) -> list[Panel]:
    """Return the plots of the missing wrench of both models."""
    forces, torques = [], []
    for side, (t, wrench) in residual.items():
        forces += [Curve(f"{axis} {side}", side, t, wrench[:, k]) for k, axis in enumerate(AXES)]
        torques.append(Curve(side, side, t, wrench[:, 2]))
    if not forces:
        return []
    return [
        Panel("force_residual", "Missing force, N", forces),
        Panel("torque_residual", "Missing torque, N·m", torques),
    ]


def episode_windows(answer: Mapping[str, Any], name: str) -> dict[str, Sequence[Window]]:
    """Return the windows of an episode in which the nominal or the extended model misfits."""
    found: dict[str, Sequence[Window]] = {}
    for key in ("mismatch", "residual"):
        windows = [each for each in (answer.get(key) or {}).get("windows") or () if each["episode"] == name]
        if windows:
            found[key] = [Window(each["start"], each["end"], each["strength"]) for each in windows]
    return found


def summary(answer: Mapping[str, Any]) -> str:
    """Return the verdict, the statements and the errors in Markdown."""
    lines = [f"# {answer['recording']}", headline(answer)]
    lines += [f"- {effect['statement']}" for effect in answer["missing"]]
    pair = (answer.get("fit") or {}).get("held_out") or {}
    errors = [(pair.get(side) or {}).get("position_rmse") for side in SIDES]
    if None not in errors:
        lines.append(
            f"Held-out position error, open loop: {errors[0]:.3g} m before, {errors[1]:.3g} m after."
        )
    return "\n\n".join(lines)
