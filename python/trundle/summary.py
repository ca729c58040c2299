"""Summary of a recording in numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from trundle.display import Card, Displayed, Table
from trundle.display.formatting import format_number

__all__ = ["EpisodeSummary", "MaskedSamples", "NoiseLevels", "RecordingSummary", "StreamSummary"]


@dataclass(frozen=True)
class NoiseLevels:
    """Standard deviations of the measurements.

    Attributes
    ----------
    pose : tuple of three floats
        Of an object pose, m, m, rad.
    force, torque : float
        Of each force axis, N, and of the torque, N·m.
    time : float
        Of the time stamps, s.
    stated : bool
        Whether the recording states the noise. Otherwise it is estimated from the data.
    """

    pose: tuple[float, float, float]
    force: float
    torque: float
    time: float
    stated: bool


@dataclass(frozen=True)
class StreamSummary:
    """Summary of a stream.

    Attributes
    ----------
    samples : int
    rate : float or None
        Sampling rate from the median interval, Hz; None for fewer than two samples.
    gaps : int
        Number of intervals longer than five median intervals.
    longest_gap : float
        The longest interval between samples, s.
    """

    samples: int
    rate: float | None
    gaps: int
    longest_gap: float


@dataclass(frozen=True)
class MaskedSamples:
    """Numbers of masked and missing samples.

    Attributes
    ----------
    pose_outliers, pose_held, pose_gaps : int
        Object poses that are tracking errors or repeat the previous one, and drop-outs.
    gripper_outliers, gripper_held : int
        Gripper poses that are tracking errors or repeat the previous one.
    wrench_gaps, before_first_pose, stale_pose : int
        Drop-outs of the wrench, and wrenches before the first pose or whose latest pose is before a drop-out.
    """

    pose_outliers: int
    pose_held: int
    pose_gaps: int
    gripper_outliers: int
    gripper_held: int
    wrench_gaps: int
    before_first_pose: int
    stale_pose: int


@dataclass(frozen=True)
class EpisodeSummary:
    """Summary of an episode.

    Attributes
    ----------
    name : str
    held_out : bool
        Whether the episode is predicted and never fitted.
    span : tuple of two floats
        First and last time, s.
    contact : float
        Start of contact, s.
    object, wrench : StreamSummary
    gripper : StreamSummary or None
    counts : MaskedSamples
    wrench_range : tuple of three pairs of floats
        Smallest and largest force x, force y (N) and torque (N·m) after the tare, in the axes of the reading.
    peak_force : float
        Largest force, N.
    tare_sd : tuple of three floats
        Standard deviation of the error of the tare, N, N, N·m.
    travel : tuple of two floats
        Path length of the object's origin, m, and total absolute rotation, rad.
    peak_speed : tuple of two floats, or None
        Largest speed, m/s, and angular speed, rad/s; None with fewer than five poses.
    """

    name: str
    held_out: bool
    span: tuple[float, float]
    contact: float
    object: StreamSummary
    gripper: StreamSummary | None
    wrench: StreamSummary
    counts: MaskedSamples
    wrench_range: tuple[tuple[float, float], tuple[float, float], tuple[float, float]]
    peak_force: float
    tare_sd: tuple[float, float, float]
    travel: tuple[float, float]
    peak_speed: tuple[float, float] | None

    @property
    def duration(self) -> float:
        """Time from the first to the last row, s."""
        return self.span[1] - self.span[0]

    @classmethod
    def parse(cls, found: Mapping[str, Any]) -> EpisodeSummary:
        """Build a summary from the result of the native module."""
        gripper, speed = found["gripper"], found["peak_speed"]
        return cls(
            **{key: found[key] for key in ("name", "held_out", "contact", "peak_force")},
            span=tuple(found["span"]),
            object=StreamSummary(**found["object"]),
            gripper=None if gripper is None else StreamSummary(**gripper),
            wrench=StreamSummary(**found["wrench"]),
            counts=MaskedSamples(**found["counts"]),
            wrench_range=tuple((low, high) for low, high in found["wrench_range"]),  # type: ignore[arg-type]
            tare_sd=tuple(found["tare_sd"]),
            travel=tuple(found["travel"]),
            peak_speed=None if speed is None else tuple(speed),
        )


@dataclass(frozen=True, repr=False)
class RecordingSummary(Displayed):
    """Summary of a recording.

    Attributes
    ----------
    name : str
    noise : NoiseLevels
    mass : float
        Mass of the object, kg: stated, or a first estimate from force and acceleration.
    mass_given : bool
        Whether the recording states the mass.
    episodes : tuple of EpisodeSummary

    Examples
    --------
    >>> summary = trundle.inspect(recording)
    >>> summary.episodes[0].held_out
    False
    >>> summary.episodes[0].object.rate > 50
    True
    """

    name: str
    noise: NoiseLevels
    mass: float
    mass_given: bool
    episodes: tuple[EpisodeSummary, ...]

    @classmethod
    def parse(cls, found: Mapping[str, Any]) -> RecordingSummary:
        """Build a summary from the result of the native module."""
        noise = {**found["noise"], "pose": tuple(found["noise"]["pose"])}
        episodes = tuple(map(EpisodeSummary.parse, found["episodes"]))
        return cls(found["name"], NoiseLevels(**noise), found["mass"], found["mass_given"], episodes)

    def to_dict(self) -> dict[str, Any]:
        """Return the fields, as in the output of ``trundle info --json``."""
        return asdict(self)

    def _card(self) -> Card:
        source = "stated" if self.mass_given else "first estimate"
        x, y, theta = self.noise.pose
        noise = (
            f"{1e3 * max(x, y):.3g} mm, {1e3 * theta:.3g} mrad, {self.noise.force:.3g} N, "
            f"{self.noise.torque:.3g} N·m ({'stated' if self.noise.stated else 'estimated'})"
        )
        facts = [("mass", f"{self.mass:.4g} kg ({source})"), ("noise", noise)]
        heads = (
            "episode",
            "split",
            "s",
            "contact s",
            "pose Hz",
            "wrench Hz",
            "peak N",
            "travel m",
            "turn rad",
        )
        rows = [_row(episode) for episode in self.episodes]
        return Card(f"trundle.RecordingSummary {self.name!r}", facts, Table(heads, rows))


def _row(episode: EpisodeSummary) -> tuple[str, ...]:
    return (
        episode.name,
        "held out" if episode.held_out else "training",
        f"{episode.duration:.2f}",
        f"{episode.contact:.2f}",
        format_number(episode.object.rate),
        format_number(episode.wrench.rate),
        f"{episode.peak_force:.1f}",
        f"{episode.travel[0]:.3f}",
        f"{episode.travel[1]:.2f}",
    )
