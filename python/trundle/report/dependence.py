"""What a missing wrench depends on: quantities that predict it in episodes that were left out."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from trundle.report.figures.motion import interpolate_poses
from trundle.report.series import Array, Episode, Series

__all__ = ["MIN_SHARE", "predictors"]

MIN_SHARE = 0.1
"""Smallest share of the missing wrench that counts as a dependence."""

_WINDOW_SHARE = 1.0 / 30.0
"""Share of an episode over which velocities are taken from the recorded poses: 0.2 s of 6 s."""
_MAX_SAMPLES = 400
"""About the largest number of samples of an episode."""
_REST_SHARE = 0.05
"""Share of the largest speed, and of the largest spin, below which the object counts as resting."""

Bins = npt.NDArray[np.int64]
Samples = dict[str, Array]
"""Columns over all samples of the training episodes: quantities, and `episode`."""


def predictors(series: Series) -> list[tuple[str, float]]:
    """Return quantities and the share of the missing wrench that each predicts, largest first.

    The wrench is divided by its noise, and predicted by its mean in bins of the quantity, in object or in
    world axes. The means come from all training episodes but one, the share from that one: 1 minus the
    ratio of squared errors to squares. It is zero if the quantity predicts nothing. The list is empty for
    fewer than two training episodes, and on a rail.
    """
    found = [_episode_samples(index, episode) for index, episode in enumerate(series.episodes)]
    parts = [part for part in found if part is not None]
    if len(parts) < 2 or "theta" not in series.dof:
        return []
    samples = {name: np.concatenate([part[name] for part in parts]) for name in parts[0]}
    shares = [(name, _best_share(bins(samples), samples)) for name, bins in _QUANTITIES]
    return sorted(shares, key=lambda entry: -entry[1])


def _episode_samples(index: int, episode: Episode) -> Samples | None:
    """Return the samples of a training episode; None without a missing wrench."""
    residual = episode.residual
    missing = None if residual is None else residual.after if residual.before is None else residual.before
    if episode.held_out or residual is None or missing is None or residual.sd is None:
        return None
    few = slice(None, None, max(1, len(residual.t) // _MAX_SAMPLES))
    t = residual.t[few]
    half = 0.5 * _WINDOW_SHARE * (t[-1] - t[0])
    if half <= 0.0:
        return None
    pose, before, after = (interpolate_poses(t + shift, episode) for shift in (0.0, -half, half))
    velocity = (after - before) / (2.0 * half)
    heading, course = pose[:, 2], np.arctan2(velocity[:, 1], velocity[:, 0])
    scaled = missing[few] / np.maximum(residual.sd[few], 1e-12)
    columns = {
        "episode": np.full(len(t), float(index)),
        "x": pose[:, 0],
        "y": pose[:, 1],
        "heading": heading,
        "course": course,
        "course_on_object": course - heading,
        "speed": np.hypot(velocity[:, 0], velocity[:, 1]),
        "spin": velocity[:, 2],
        "time": t - episode.contact if np.isfinite(episode.contact) else t,
        **{f"wrench_{axis}": scaled[:, axis] for axis in range(3)},
    }
    seen = np.isfinite(np.column_stack([*columns.values()])).all(axis=1)
    return {name: column[seen] for name, column in columns.items()} if seen.any() else None


def _best_share(bins: Bins, samples: Samples) -> float:
    """Return the larger of the shares that are predicted in object axes and in world axes."""
    x, y, torque = (samples[f"wrench_{axis}"] for axis in range(3))
    cos, sin = np.cos(samples["heading"]), np.sin(samples["heading"])
    frames = ((x, y, torque), (cos * x - sin * y, sin * x + cos * y, torque))
    return max(_share(bins, samples["episode"], np.column_stack(frame)) for frame in frames)


def _share(bins: Bins, episode: Array, wrench: Array) -> float:
    """Return the share of a wrench (n, 3) that its means in bins predict in left-out episodes."""
    count = int(bins.max(initial=0)) + 1
    error = 0.0
    for left_out in np.unique(episode):
        known = episode != left_out
        size = np.bincount(bins[known], minlength=count)
        mean = (
            np.column_stack([np.bincount(bins[known], column[known], minlength=count) for column in wrench.T])
            / np.maximum(size, 1)[:, None]
        )
        error += float(((wrench[~known] - mean[bins[~known]]) ** 2).sum())
    total = float((wrench**2).sum())
    return max(0.0, 1.0 - error / total) if total > 0.0 else 0.0


def _quantiles(values: Array, count: int) -> Bins:
    edges = np.quantile(values, np.linspace(0.0, 1.0, count + 1)[1:-1])
    return np.searchsorted(edges, values).astype(np.int64)


def _angles(values: Array, count: int) -> Bins:
    return np.floor(np.mod(values, 2.0 * np.pi) / (2.0 * np.pi) * count).astype(np.int64) % count


def _crossed(first: Bins, second: Bins) -> Bins:
    return first * (int(second.max(initial=0)) + 1) + second


def _motion_bins(samples: Samples, course: str) -> Bins:
    """Return bins of the direction of motion, with one for rest."""
    rests = samples["speed"] < _REST_SHARE * samples["speed"].max()
    return np.where(rests, 12, _angles(samples[course], 12))


def _spin_bins(samples: Samples) -> Bins:
    """Return bins of the spin by sense and size, with one for rest."""
    spin = np.abs(samples["spin"])
    return np.where(spin < _REST_SHARE * spin.max(), 8, _quantiles(spin, 4) + 4 * (samples["spin"] > 0.0))


_QUANTITIES: Sequence[tuple[str, Callable[[Samples], Bins]]] = (
    ("a constant alone", lambda s: np.zeros(len(s["time"]), dtype=np.int64)),
    ("the speed", lambda s: _quantiles(s["speed"], 8)),
    ("the direction of motion on the object", lambda s: _motion_bins(s, "course_on_object")),
    ("the direction of motion in the world", lambda s: _motion_bins(s, "course")),
    ("the spin", _spin_bins),
    ("the heading", lambda s: _angles(s["heading"], 12)),
    ("the place on the floor", lambda s: _crossed(_quantiles(s["x"], 5), _quantiles(s["y"], 5))),
    ("the time since contact", lambda s: _quantiles(s["time"], 8)),
)
"""Quantities, and their bins."""
