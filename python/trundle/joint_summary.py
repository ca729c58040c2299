"""Summary of a recording of joints in numbers."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from trundle.display import Card, Displayed, Table
from trundle.display.formatting import format_number
from trundle.summary import StreamSummary

__all__ = ["JointEpisodeSummary", "JointMotion", "JointNoise", "JointSummary"]


@dataclass(frozen=True)
class JointNoise:
    """Noise of the positions of a joint.

    Attributes
    ----------
    joint : str
    position_noise : float
        Standard deviation of a position, rad or m.
    stated : bool
        Whether the recording states it. Otherwise it is estimated from the data.
    """

    joint: str
    position_noise: float
    stated: bool


@dataclass(frozen=True)
class JointMotion:
    """Motion of one joint in one episode.

    Attributes
    ----------
    joint : str
    streams : dict of str to StreamSummary
        Recorded streams by prefix: ``q``, ``v``, ``effort``, ``target``, ``known``, ``on``, ``load``.
    position_range : tuple of two floats
        Smallest and largest position, rad or m.
    peak_speed : float or None
        Largest speed, rad/s or m/s; None with fewer than ten samples.
    effort_range : tuple of two floats, or None
        Smallest and largest effort as recorded; None without one.
    """

    joint: str
    streams: Mapping[str, StreamSummary]
    position_range: tuple[float, float]
    peak_speed: float | None
    effort_range: tuple[float, float] | None

    @classmethod
    def parse(cls, found: Mapping[str, Any]) -> JointMotion:
        """Build a summary from the result of the native module."""
        streams = {prefix: StreamSummary(**stream) for prefix, stream in found["streams"].items()}
        low, high = found["position_range"]
        effort = found["effort_range"]
        efforts = None if effort is None else (effort[0], effort[1])
        return cls(found["joint"], streams, (low, high), found["peak_speed"], efforts)


@dataclass(frozen=True)
class JointEpisodeSummary:
    """Summary of an episode of a recording of joints.

    Attributes
    ----------
    name : str
    held_out : bool
        Whether the episode is predicted and never fitted.
    span : tuple of two floats
        First and last time, s.
    joints : tuple of JointMotion
    """

    name: str
    held_out: bool
    span: tuple[float, float]
    joints: tuple[JointMotion, ...]

    @property
    def duration(self) -> float:
        """Time from the first to the last row, s."""
        return self.span[1] - self.span[0]


@dataclass(frozen=True, repr=False)
class JointSummary(Displayed):
    """Summary of a recording of joints.

    Attributes
    ----------
    name : str
    model : str or None
        Path of the model inside the folder; None for an axis without a model.
    joints : tuple of JointNoise
    episodes : tuple of JointEpisodeSummary

    Examples
    --------
    >>> import numpy as np
    >>> t = np.arange(0.0, 2.0, 0.01)
    >>> mechanism = {"axis": "hinge", "joints": ["arm"]}
    >>> metadata = {"format": "trundle-recording/2", "name": "bench", "mechanism": mechanism}
    >>> bench = trundle.JointRecording(metadata, {"sine": {"t": t, "q_arm": np.sin(t)}})
    >>> round(trundle.inspect(bench).episodes[0].joints[0].peak_speed, 2)
    1.0
    """

    name: str
    model: str | None
    joints: tuple[JointNoise, ...]
    episodes: tuple[JointEpisodeSummary, ...]

    @classmethod
    def parse(cls, found: Mapping[str, Any]) -> JointSummary:
        """Build a summary from the result of the native module."""
        episodes = tuple(
            JointEpisodeSummary(
                one["name"],
                one["held_out"],
                (one["span"][0], one["span"][1]),
                tuple(map(JointMotion.parse, one["joints"])),
            )
            for one in found["episodes"]
        )
        return cls(
            found["name"], found["model"], tuple(JointNoise(**one) for one in found["joints"]), episodes
        )

    def to_dict(self) -> dict[str, Any]:
        """Return the fields, as in the output of ``trundle info --json``."""
        return asdict(self)

    @property
    def table(self) -> Table:
        """One row per episode and joint."""
        heads = (
            "episode",
            "split",
            "s",
            "joint",
            "q Hz",
            "gaps",
            "q from",
            "to",
            "peak v",
            "effort from",
            "to",
        )
        return Table(heads, [_row(one, joint) for one in self.episodes for joint in one.joints])

    @property
    def mechanism(self) -> str:
        """The model, or that there is none."""
        if self.model:
            return f"model {self.model}"
        return "one axis, no model" if len(self.joints) == 1 else "no model"

    def _card(self) -> Card:
        facts = [
            ("mechanism", self.mechanism),
            ("noise", ", ".join(format_noise(joint) for joint in self.joints)),
        ]
        return Card(f"trundle.JointSummary {self.name!r}", facts, self.table)


def format_noise(joint: JointNoise) -> str:
    """Format the noise of a joint."""
    return f"{joint.joint} {joint.position_noise:.3g} ({'stated' if joint.stated else 'estimated'})"


def _row(episode: JointEpisodeSummary, joint: JointMotion) -> tuple[str, ...]:
    positions = joint.streams["q"]
    low, high = joint.effort_range or (None, None)
    return (
        episode.name,
        "held out" if episode.held_out else "training",
        f"{episode.duration:.2f}",
        joint.joint,
        format_number(positions.rate),
        str(positions.gaps),
        format_number(joint.position_range[0], 3),
        format_number(joint.position_range[1], 3),
        format_number(joint.peak_speed, 3),
        format_number(low, 3),
        format_number(high, 3),
    )
