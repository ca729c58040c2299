"""Units of length, angle, time, force and torque, with the spellings that loggers use."""

from __future__ import annotations

import re

import numpy as np

__all__ = ["UNITS", "unit_in"]

UNITS: dict[str, dict[str, float]] = {
    "length": {"m": 1.0, "cm": 1e-2, "mm": 1e-3, "um": 1e-6},
    "angle": {"rad": 1.0, "deg": np.pi / 180.0},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9},
    "force": {"N": 1.0, "mN": 1e-3, "kN": 1e3},
    "torque": {"N m": 1.0, "N cm": 1e-2, "N mm": 1e-3},
    "ratio": {"1": 1.0},
}
"""Size of each unit in SI units, by dimension; the first unit of a dimension is that of SI."""

SPELLINGS = {
    "m": "m meter meters metre metres",
    "cm": "cm centimeter centimeters centimetre centimetres",
    "mm": "mm millimeter millimeters millimetre millimetres",
    "um": "um µm μm micron microns micrometer micrometers",
    "rad": "rad rads radian radians",
    "deg": "deg degs degree degrees ° º",
    "s": "s sec secs second seconds",
    "ms": "ms msec msecs millis millisec millisecond milliseconds",
    "us": "us µs μs usec usecs micros microsec microsecond microseconds",
    "ns": "ns nsec nsecs nanos nanosec nanosecs nanosecond nanoseconds",
    "N": "N n newton newtons",
    "mN": "mN",
    "kN": "kN kn",
    "N m": "Nm nm NM newtonmeter newtonmeters newtonmetre newtonmetres",
    "N cm": "Ncm ncm",
    "N mm": "Nmm nmm mNm",
}
BY_SPELLING = {spelling: unit for unit, spellings in SPELLINGS.items() for spelling in spellings.split()}


def unit_in(text: str) -> str | None:
    """Return the unit that a text such as "N*m" or "degrees" spells, as in `UNITS`; None for another text."""
    short = re.sub(r"[\s*·⋅._-]", "", text)
    return BY_SPELLING.get(short) or (BY_SPELLING.get(short.lower()) if len(short) > 3 else None)
