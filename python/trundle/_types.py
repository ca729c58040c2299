"""Types of what crosses from the native half as dictionaries.

`float | Any` is a float or None. A caller who knows that a parameter is identifiable, or that there are
held-out episodes, need not check for None (the "Any trick" of typeshed).
"""

from __future__ import annotations

from typing import Any, Literal, TypedDict

import numpy as np
from numpy.typing import NDArray

__all__ = [
    "Answer",
    "CalibrationRound",
    "CalibrationTable",
    "Estimate",
    "FitSummary",
    "IntervalBasis",
    "JointAnswer",
    "JointEffectEntry",
    "JointFittedModel",
    "JointMotion",
    "JointMotionEpisode",
    "LackOfFit",
    "MissingEffect",
    "Noise",
    "ParameterCoverage",
    "Profile",
    "SampleSummary",
    "SampledParameter",
    "Score",
]


class Estimate(TypedDict):
    """A free parameter after pushes, SI units; numbers are None where it is not identifiable."""

    name: str
    mean: float | Any
    sd: float | Any
    unit: str
    identifiable: bool


class FittedParameter(Estimate):
    """A free parameter after a fit, with the ends of its 90 % interval."""

    low: float | Any
    high: float | Any


class Noise(TypedDict):
    """Standard deviations: of a pose (m, m, rad), of the force (N) and of the torque (N m)."""

    pose: list[float]
    force: float
    torque: float
    stated: bool


class LackOfFit(TypedDict):
    """Result of the lack-of-fit test; forces in N, torques in N m."""

    found: bool
    gain_nats: float
    residual_force_rms: float
    residual_torque_rms: float


class IntervalBasis(TypedDict):
    """Which covariance the intervals come from, and the number of episodes of the sandwich."""

    coverage: float
    basis: Literal["curvature", "sandwich"]
    episodes: int | None


Score = dict[str, Any]
"""Error figures of some episodes, docs/diagnosis.md."""


class FitSummary(TypedDict):
    """Summary of a fit, docs/estimation.md."""

    recording: str
    parameters: list[FittedParameter]
    log_evidence: float | Any
    converged: bool
    quasi_static: bool
    lack_of_fit: LackOfFit | None
    intervals: IntervalBasis
    noise: Noise
    training: Score
    held_out: Score | Any
    excluded_by_prior: list[str]
    identifiability: dict[str, Any]
    likelihood: str
    loss: str


class Profile(TypedDict):
    """Profile of a parameter: deviance (chi-squared) over its values, SI units."""

    name: str
    unit: str
    values: list[float]
    deviance: list[float]
    interval: tuple[float | None, float | None]
    shape: Literal["two-sided", "at least", "at most", "flat"]
    modes: list[float]
    mean: float | Any
    sd: float | Any


class SampledParameter(TypedDict):
    """A free parameter of a posterior."""

    name: str
    unit: str
    identifiable: bool


class SampleSummary(TypedDict):
    """Summary of a posterior's run."""

    recording: str
    parameters: list[SampledParameter]
    modes: list[dict[str, Any]]
    excluded_by_prior: list[str]
    quasi_static: bool
    lack_of_fit: LackOfFit | None
    step_sizes: list[float]
    acceptance: list[float]
    warmup_evaluations: int
    noise: Noise


CalibrationRound = dict[str, Any]
"""A round: `index`, and of each parameter truth, mean, standard deviation and rank."""


class ParameterCoverage(TypedDict):
    """Coverage of a parameter's intervals; shares come with the ends of their 95 % intervals."""

    name: str
    rounds: int
    cover_50: list[float]
    cover_90: list[float]
    uniform_p: float
    histogram: list[int]
    mean_rank: float


class CalibrationTable(TypedDict):
    """Result of a calibration."""

    name: str
    method: str
    parameters: list[ParameterCoverage]


class MissingEffect(TypedDict, total=False):
    """A named effect of `diagnosis.json`."""

    effect: str
    probability: float
    statement: str
    parameters: dict[str, dict[str, Any]]
    where: dict[str, Any]
    explains: dict[str, Any]
    experiment: str


class Answer(TypedDict, total=False):
    """The content of `diagnosis.json`, docs/diagnosis.md."""

    format: str
    recording: str
    verdict: Literal["consistent", "reparameterised", "explained", "unexplained"]
    missing: list[MissingEffect]
    alternatives: list[MissingEffect]
    immaterial: list[MissingEffect]
    tied: list[list[str]]
    tied_sets: list[list[list[str]]]
    warnings: list[str]
    nominal: dict[str, Any]
    mismatch: dict[str, Any]
    residual: dict[str, Any]
    fit: dict[str, Any]
    certificates: list[dict[str, Any]]
    experiments: list[dict[str, Any]]


class JointMotionEpisode(TypedDict):
    """Smoothed motion of an episode: times (T,), s, and positions, velocities and accelerations, (T, n).

    The causal positions and velocities are those that the samples up to each time tell.
    """

    t: NDArray[np.float64]
    q: NDArray[np.float64]
    v: NDArray[np.float64]
    a: NDArray[np.float64]
    causal_q: NDArray[np.float64]
    causal_v: NDArray[np.float64]


class JointMotion(TypedDict):
    """Smoothed motion of a recording of joints; the bandwidth is in Hz."""

    joints: list[str]
    bandwidth: float
    episodes: dict[str, JointMotionEpisode]


class JointFittedModel(TypedDict):
    """A fitted mechanism: nominal values, and effects with kind, joint or body, and values."""

    nominal: dict[str, float]
    effects: list[dict[str, Any]]


class JointEffectEntry(TypedDict):
    """An entry of the catalogue of laws of joints; parameters have a name and a unit."""

    effect: str
    summary: str
    source: str
    parameters: list[dict[str, str]]
    experiment: str


class JointAnswer(TypedDict):
    """The content of ``diagnosis.json`` of a recording of joints."""

    format: str
    recording: str
    verdict: Literal["consistent", "reparameterised", "explained", "unexplained"]
    missing: list[dict[str, Any]]
    tied: list[list[str]]
    tied_sets: list[list[list[str]]]
    immaterial: list[dict[str, Any]]
    mismatch: dict[str, Any]
    residual: dict[str, Any]
    warnings: list[str]
    alternatives: list[dict[str, Any]]
    nominal: dict[str, dict[str, Any]]
    fit: dict[str, Any]
