"""Figures of the report of a diagnosis of joints."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np
from numpy.typing import NDArray

from trundle.joint_diagnosis.held_out import Path
from trundle.joint_diagnosis.residuals import JointEfforts
from trundle.report.figures.canvas import Figure, figure, label
from trundle.report.figures.curves import Curve, Lane
from trundle.report.figures.data import Data
from trundle.report.figures.lanes import lane_figure
from trundle.report.svg import tag

__all__ = ["chain_figure", "law_figures", "time_figure"]

Floats = NDArray[np.float64]

MAX_DOTS = 500
"""Dots in a scatter plot."""
BINS = 30
"""Points of the line of a fitted law."""
OUTLIERS = (0.005, 0.995)
"""Quantiles that the axis of a scatter plot contains with a margin."""
LANE_HEIGHT = 120.0
"""Height of the scatter plots, user units."""


def chain_figure(joints: Sequence[str], marked: Collection[str], kinds: Sequence[str]) -> Figure:
    """Draw the joints as a chain from the base, with some of them marked.

    Parameters
    ----------
    joints, kinds : sequence of str
        Names, and "hinge" or "slide".
    marked : collection of str
        Joints that the effects concern.
    """
    spacing, left = 46.0, 70.0
    height = 40.0 + spacing * len(joints)
    parts = [tag("line", x1=left, x2=left, y1=18.0, y2=height - 34.0, class_="strong")]
    parts.append(tag("rect", x=left - 22.0, y=10.0, width=44.0, height=12.0, class_="support"))
    parts.append(label("base", left + 32.0, 20.0, "tick"))
    for k, (joint, kind) in enumerate(zip(joints, kinds, strict=True)):
        y = 22.0 + spacing * (k + 0.8)
        style = "likely" if joint in marked else "support"
        if joint in marked:
            parts.append(tag("circle", cx=left, cy=y, r=18.0, class_="ghost"))
        if kind == "hinge":
            parts.append(tag("circle", cx=left, cy=y, r=11.0, class_="support"))
            parts.append(tag("circle", cx=left, cy=y, r=11.0, class_=style))
        else:
            parts.append(tag("rect", x=left - 14.0, y=y - 8.0, width=28.0, height=16.0, class_="support"))
            parts.append(tag("rect", x=left - 14.0, y=y - 8.0, width=28.0, height=16.0, class_=style))
        text = f"{joint}: here" if joint in marked else joint
        parts.append(label(text, left + 32.0, y + 5.0, "number small" if joint in marked else "tick"))
    listed = ", ".join(marked) if marked else "none"
    rows = [
        [joint, kind, "yes" if joint in marked else "no"] for joint, kind in zip(joints, kinds, strict=True)
    ]
    description = f"The joints {', '.join(joints)} in order from the base. Marked: {listed}."
    return figure(
        "mechanism",
        "Mechanism",
        description,
        height,
        parts,
        ("Mechanism. ", "Circles are hinges, rectangles are slides; the marked joints have missing physics."),
        data=Data(("joint", "kind", "marked"), rows),
    )


def law_figures(joint: str, efforts: Sequence[JointEfforts], units: tuple[str, str]) -> list[Figure]:
    """Draw the missing effort of a joint against speed, position and load, with the fitted law.

    Parameters
    ----------
    joint : str
    efforts : sequence of JointEfforts
        Of each training episode.
    units : tuple of str
        Of positions and of efforts.
    """
    position, effort = units
    axes = (
        ("speed", f"velocity, {position}/s", np.concatenate([one.v for one in efforts])),
        ("position", f"position, {position}", np.concatenate([one.q for one in efforts])),
        ("load", f"transmitted load, {effort}", np.concatenate([one.load for one in efforts])),
    )
    recorded, before, after, law = (
        np.concatenate([getattr(one, key) for one in efforts])
        for key in ("recorded", "before", "after", "law")
    )
    # With the nominal values of the model "after": what remains, and what the laws exert.
    missing = recorded - after - law
    found = []
    for name, title, x in axes:
        if not np.ptp(x) > 0:
            continue
        lanes = [
            _scatter(f"resisting effort, {effort}", x, [("recorded", missing)], ("after", -law)),
            _scatter(f"required less recorded, {effort}: before", x, [("before", before - recorded)]),
            _scatter("the same: after", x, [("after", after - recorded)]),
        ]
        if not np.isfinite(after).any():
            lanes = lanes[1:2]
        description = f"Effort at joint {joint} that the nominal model does not explain, against {name}."
        found.append(
            lane_figure(
                f"law-{joint}-{name}",
                f"Joint {joint} against {name}",
                description,
                lanes,
                (float(x.min()), float(x.max())),
                (f"{joint}, {name}. ", "Dots: training samples. Line: the fitted laws."),
                axis=title,
            )
        )
    return found


def _scatter(
    title: str, x: Floats, dots: Sequence[tuple[str, Floats]], line: tuple[str, Floats] | None = None
) -> Lane:
    """Return dots, and a line through the medians of the values in bins of x."""
    order = np.argsort(x, kind="stable")
    rows = order[:: max(1, len(order) // MAX_DOTS)]
    curves = [Curve(f"{style} dots", x[rows], values[rows], is_dotted=True) for style, values in dots]
    if line is not None:
        style, values = line
        edges = np.linspace(x.min(), x.max(), BINS + 1)
        place = np.clip(np.searchsorted(edges, x, side="right") - 1, 0, BINS - 1)
        bins = [k for k in range(BINS) if (place == k).any()]
        middle = np.array([np.median(x[place == k]) for k in bins])
        medians = np.array([np.median(values[place == k]) for k in bins])
        curves.append(Curve(style, middle, medians))
    values = np.concatenate([values[np.isfinite(values)] for _, values in dots])
    low, high = np.quantile(values, OUTLIERS) if len(values) else (-1.0, 1.0)
    margin = 0.3 * (high - low) or 1.0
    return Lane(title, tuple(curves), (float(low - margin), float(high + margin)), height=LANE_HEIGHT)


def time_figure(
    episode: str, joint: str, k: int, efforts: JointEfforts, path: Path | None, units: tuple[str, str]
) -> Figure:
    """Draw recorded and simulated positions, and recorded and required efforts, of a held-out episode."""
    position, effort = units
    lanes = []
    if path is not None:
        curves = [Curve("recorded", path.t, path.observed[:, k])]
        for style in ("before", "after"):
            values = getattr(path, style)
            if values is not None:
                curves.append(Curve(style, path.t, values[:, k]))
        spread = np.ptp(path.observed[:, k]) or 1.0
        middle = (path.observed[:, k].min() + path.observed[:, k].max()) / 2
        limits = (float(middle - spread), float(middle + spread))
        lanes.append(Lane(f"position, {position}, open loop", tuple(curves), limits, height=90.0))
        errors = [Curve(one.style, one.t, one.y - curves[0].y) for one in curves[1:]]
        if errors:
            lanes.append(Lane(f"error of the position, {position}", tuple(errors)))
    series = (("recorded", efforts.recorded), ("before", efforts.before), ("after", efforts.after))
    curves = [Curve(style, efforts.t, values) for style, values in series if np.isfinite(values).any()]
    lanes.append(Lane(f"effort, {effort}", tuple(curves), height=90.0))
    span = (float(efforts.t[0]), float(efforts.t[-1]))
    return lane_figure(
        f"held-out-{episode}-{joint}",
        f"Held-out episode {episode}, joint {joint}",
        f"Positions and efforts of joint {joint} in the held-out episode {episode}.",
        lanes,
        span,
        (f"{episode}, {joint}. ", "Simulated from the first state; the effort that each model requires."),
    )
