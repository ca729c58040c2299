"""The sentence of a design for a mechanism."""

from __future__ import annotations

from collections.abc import Sequence

from trundle.joint_design.separation import Candidate

__all__ = ["instruction", "summary"]

FEW_NATS = 0.01
"""Separation below which its size does not matter."""
MANY_NATS = 1000.0
"""Separation beyond which the number does not matter."""


def instruction(candidate: Candidate) -> str:
    """Return what to do, as one sentence."""
    words = candidate.trajectory.words
    return f"{words}, {candidate.rig.words}." if candidate.rig.words else f"{words}."


def summary(
    models: tuple[str, str],
    best: Candidate | None,
    recorded_best: Candidate | None,
    tried: Sequence[str],
    advice: Sequence[str],
    threshold: float,
    sure: float,
    repeats: int | None,
) -> str:
    """Return the result in words.

    Parameters
    ----------
    models : tuple of two str
    best : Candidate, optional
        The chosen one, if it reaches the threshold.
    recorded_best : Candidate, optional
        The best one on the recorded rig.
    tried : sequence of str
        Changes of the rig that were tried.
    advice : sequence of str
        What the catalogue advises for the effects.
    threshold, sure, repeats
        As in `JointDesign`.
    """
    parts = []
    if best is None or best.rig.kind not in ("as_recorded", "covariate") or best is not recorded_best:
        reached = 0.0 if recorded_best is None else recorded_best.value
        if reached < threshold:
            parts.append(
                f"No trajectory within the limits separates {models[0]} from {models[1]} on this rig: the "
                f"best reaches {_nats(reached)} of the {threshold:.1f} nats that a probability of 0.95 needs."
            )
    if best is None:
        if tried:
            parts.append(f"Nor does it {', '.join(tried[:-1])}{' or ' if tried[1:] else ''}{tried[-1]}.")
        if advice:
            parts.append(f"The catalogue advises: {'; '.join(advice)}.")
        return " ".join(parts)
    first, second = map(_nats, best.separation)
    repeated = {1: "", None: "; repetitions do not raise it to 95 %"}.get(
        repeats, f"; with {repeats} repetitions it is at least 95 %"
    )
    return " ".join(
        [
            *parts,
            instruction(best),
            f"The expected log-likelihood ratio is {first} nats if {models[0]} is true and {second} nats if "
            f"{models[1]} is true. The chance that the true model then has a probability above 0.95 is "
            f"{100 * sure:.0f} %{repeated}.",
        ]
    )


def _nats(value: float) -> str:
    if value > MANY_NATS:
        return "over 1000"
    if value < FEW_NATS:
        return f"under {FEW_NATS}"
    return f"{value:.2g}" if value < 10 else f"{value:.0f}"
