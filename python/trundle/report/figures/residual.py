"""Missing wrench of one episode over time, before and after, with the windows that exceed the noise."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from trundle.report.figures import lanes
from trundle.report.figures.canvas import Figure
from trundle.report.figures.curves import Curve, Lane, Marks, bounds
from trundle.report.figures.motion import events_in
from trundle.report.location import Place
from trundle.report.series import Episode, Residual, Series, finite

__all__ = ["CHANNELS", "draw", "select_episodes", "windows_in"]

CHANNELS = (("force along x", "N"), ("force along y", "N"), ("torque", "N·m"))
"""Name and unit of each wrench component, object axes."""


def select_episodes(
    series: Series, windows: Sequence[Mapping[str, Any]], sides: Sequence[str]
) -> list[Episode]:
    """Return the episodes that can be drawn: strongest windows first, then held-out episodes."""
    strongest = {episode.name: _strongest(episode, windows) for episode in series.episodes}
    drawable = [
        episode
        for episode in series.episodes
        if (found := episode.residual) is not None
        and len(found.t) > 1
        and any(getattr(found, side) is not None for side in sides)
    ]
    return sorted(drawable, key=lambda episode: (-strongest[episode.name], not episode.held_out))


def windows_in(episode: Episode, windows: Sequence[Mapping[str, Any]]) -> list[tuple[float, float]]:
    """Return the windows of one episode as (start, end), s."""
    pairs = [
        (finite(w.get("start")), finite(w.get("end"))) for w in windows if w.get("episode") == episode.name
    ]
    return [(start, end) for start, end in pairs if start is not None and end is not None]


def draw(
    identity: str,
    episode: Episode,
    residual: Residual,
    series: Series,
    windows: Sequence[Mapping[str, Any]],
    named: Sequence[Place],
    shown: Sequence[str],
) -> Figure:
    """Return the panel of one episode, with the sides in `shown`; `identity` is unique in the page."""
    rows = [lane for channel in series.channels for lane in _channel_lanes(channel, residual, shown)]
    inside = windows_in(episode, windows)
    span = (float(residual.t[0]), float(residual.t[-1]))
    text = "Missing force and torque over time. The grey band shows two standard deviations of the noise."
    kind = "held out" if episode.held_out else "fitted"
    count = _window_count_sentence(inside, episode.held_out)
    return lanes.lane_figure(
        f"residual-{identity}",
        f"Missing wrench in {episode.name}",
        f"{text} {count}",
        rows,
        span,
        (episode.name, f" ({kind}). {count}"),
        marks=Marks(inside, events_in(episode, named)),
    )


def _strongest(episode: Episode, windows: Sequence[Mapping[str, Any]]) -> float:
    strengths = [finite(w.get("strength")) for w in windows if w.get("episode") == episode.name]
    return max((strength for strength in strengths if strength is not None), default=0.0)


def _channel_lanes(channel: int, residual: Residual, shown: Sequence[str]) -> list[Lane]:
    """Return the lanes of one channel, with the same value axis before and after."""
    name, unit = CHANNELS[channel]
    sides = [(side, curve[:, channel]) for side in shown if (curve := getattr(residual, side)) is not None]
    curves = {side: Curve(f"{side} whole", residual.t, values) for side, values in sides}
    noise = {side: _band(residual, side, channel) for side in curves}
    drawn = (*curves.values(), *(band for bands in noise.values() for band in bands))
    reach = max((abs(limit) for curve in drawn for limit in bounds([curve])), default=1.0)
    return [
        Lane(
            _title(name, unit, side if len(curves) > 1 else ""),
            (*noise[side], curve),
            (-reach, reach),
            height=46.0,
        )
        for side, curve in curves.items()
    ]


def _title(name: str, unit: str, side: str) -> str:
    return f"{name}, {unit} · {side}" if side else f"{name}, {unit}"


def _band(residual: Residual, side: str, channel: int) -> list[Curve]:
    """Return the band of two standard deviations of a side's noise; "after" defaults to that of "before"."""
    sd = residual.sd_after if side == "after" and residual.sd_after is not None else residual.sd
    return [] if sd is None else [Curve("band", residual.t, np.zeros(len(sd)), 2.0 * sd[:, channel])]


def _window_count_sentence(windows: Sequence[tuple[float, float]], held_out: bool) -> str:
    """Return how many windows exceed the noise; they are searched in fitted episodes only."""
    if not windows:
        return "" if held_out else "No window exceeds the noise."
    return (
        "One window exceeds the noise." if len(windows) == 1 else f"{len(windows)} windows exceed the noise."
    )
