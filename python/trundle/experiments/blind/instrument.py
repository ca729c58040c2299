"""Instruments of a recording, and the conventions of its table."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

__all__ = ["FRAMES", "Instrument"]

FRAMES = (
    ("sensor", "sensor"),
    ("sensor", "object"),
    ("object", "object"),
    ("object", "sensor"),
    ("world", "sensor"),
    ("world", "object"),
)
"""Axes of the reading and reference point of its torque."""


@dataclass(frozen=True)
class Instrument:
    """Instruments and conventions of a recording.

    Attributes
    ----------
    tracker, sensor : float
        Sample rates, Hz.
    pose, heading, force, torque : float
        Noise in m, N and N·m; heading noise in rad times the radius of gyration in m.
    dropout, burst : float, bool
        Share of tracker samples that are lost, and whether they are lost in bursts.
    jitter : float
        Standard deviation of the time stamps, s.
    filtered : bool
        Whether each reading is the mean over its sample period (an anti-alias filter without delay).
    frame, reference, sign : str
        As in `[wrench]` of a recording.
    raw : bool
        Whether the readings include the sensor's offset.
    contact : str
        "grasp", "compliant" (a compliant grasp) or "point" (free pushing).
    torque_given, noise_given : bool
        Whether the recording has `torque_z` (always for a grasp), and states its noise.
    shifted : bool
        Whether the clock of each episode has a random start.
    """

    tracker: float
    sensor: float
    pose: float
    heading: float
    force: float
    torque: float
    dropout: float = 0.0
    burst: bool = False
    jitter: float = 0.0
    filtered: bool = False
    frame: str = "sensor"
    reference: str = "sensor"
    sign: str = "on_object"
    raw: bool = True
    contact: str = "grasp"
    torque_given: bool = True
    noise_given: bool = True
    shifted: bool = False

    @property
    def rate_class(self) -> str:
        """Class of the effective rate of poses."""
        rate = self.tracker * (1.0 - self.dropout)
        return "below 20 Hz" if rate < 20.0 else "20 to 60 Hz" if rate < 60.0 else "60 Hz and more"

    @property
    def noise_class(self) -> str:
        """Class of the pose noise."""
        few, many = self.pose < 5e-4, self.pose >= 1.5e-3
        return "below 0.5 mm" if few else "1.5 mm and more" if many else "0.5 to 1.5 mm"

    def plain(self) -> dict[str, Any]:
        """Return the instrument with its classes, as plain values."""
        return {**asdict(self), "rate_class": self.rate_class, "noise_class": self.noise_class}
