"""Instruments of a case and conventions of its recording."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from trundle.experiments.sampling import log_uniform

__all__ = ["Instrument", "draw_instrument"]

FRAMES = (
    ("sensor", "sensor"),
    ("sensor", "object"),
    ("object", "object"),
    ("object", "sensor"),
    ("world", "sensor"),
    ("world", "object"),
)
"""Axes of the reading and reference point of its torque."""
FRAME_SHARES = (0.4, 0.08, 0.16, 0.08, 0.16, 0.12)
CONTACTS = ("grasp", "compliant", "point")
CONTACT_SHARES = (0.45, 0.25, 0.3)


@dataclass(frozen=True)
class Instrument:
    """Instruments and conventions of a recording.

    Attributes
    ----------
    tracker, sensor : float
        Sample rates, Hz.
    dropout : float
        Share of tracker samples that are lost.
    burst : bool
        Whether they are lost in bursts.
    jitter : float
        Standard deviation of the time stamps, s.
    pose, heading : float
        Noise of the tracker, m; heading noise in rad times the radius of gyration in m.
    force, torque : float
        Noise of the sensor, N, N·m.
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
    dropout: float
    burst: bool
    jitter: float
    pose: float
    heading: float
    force: float
    torque: float
    filtered: bool
    frame: str
    reference: str
    sign: str
    raw: bool
    contact: str
    torque_given: bool
    noise_given: bool
    shifted: bool

    @property
    def rate_class(self) -> str:
        """Class of the effective rate of poses."""
        rate = self.tracker * (1.0 - self.dropout)
        return "below 20 Hz" if rate < 20.0 else "20 to 60 Hz" if rate < 60.0 else "60 Hz and more"

    @property
    def noise_class(self) -> str:
        """Class of the pose noise."""
        return (
            "below 0.5 mm"
            if self.pose < 5e-4
            else "0.5 to 1.5 mm"
            if self.pose < 1.5e-3
            else "1.5 mm and more"
        )

    def plain(self) -> dict[str, Any]:
        """Return the instrument with its classes, as plain values."""
        return {**asdict(self), "rate_class": self.rate_class, "noise_class": self.noise_class}


def draw_instrument(rng: np.random.Generator) -> Instrument:
    """Return random instruments and conventions."""
    tracker, sensor = log_uniform(rng, 10.0, 250.0), log_uniform(rng, 50.0, 1000.0)
    frame, reference = FRAMES[int(rng.choice(len(FRAMES), p=FRAME_SHARES))]
    contact = str(rng.choice(CONTACTS, p=CONTACT_SHARES))
    force = log_uniform(rng, 0.05, 1.0)
    loses, jitters = rng.random() < 0.5, rng.random() < 0.5
    pose = log_uniform(rng, 1e-4, 3e-3)
    return Instrument(
        tracker=round(tracker, 1),
        sensor=round(sensor, 1),
        dropout=round(float(rng.uniform(0.05, 0.5)), 3) * loses,
        burst=bool(rng.random() < 0.5),
        jitter=jitters * min(0.1 / tracker, log_uniform(rng, 1e-4, 2e-3)),
        pose=pose,
        heading=pose * float(rng.uniform(0.6, 1.5)),
        force=force,
        torque=force * float(rng.uniform(0.05, 0.2)),
        filtered=bool(rng.random() < 0.5),
        frame=frame,
        reference=reference,
        sign=str(rng.choice(("on_object", "on_sensor"), p=(0.6, 0.4))),
        # An offset about the object's origin is constant only where the grasp is rigid.
        raw=frame == "sensor" and bool(rng.random() < 0.6) and (reference == "sensor" or contact == "grasp"),
        contact=contact,
        torque_given=contact != "point" or bool(rng.random() < 0.5),
        noise_given=bool(rng.random() < 0.6),
        shifted=bool(rng.random() < 0.3),
    )
