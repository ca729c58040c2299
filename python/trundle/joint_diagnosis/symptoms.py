"""The headline of a diagnosis of joints, and what is known about an effect without a name."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from trundle._types import JointAnswer
from trundle.report.quantity import format_fixed, format_interval, format_significant, join_words
from trundle.report.verdict import PLAIN_VERDICTS
from trundle.report.wording import format_percent

__all__ = ["headline", "name_of_effect", "residual_sentence", "symptoms"]

MAIN_SHARE = 0.1
"""Share of the misfit from which a joint is one of those where an effect is missing."""

BOTH_DIRECTIONS = (
    "Move {joint} at constant speeds in both directions, and record its effort at rest without a load. "
    "An offset of the effort stays at rest; friction that differs by direction does not."
)
PAUSE = (
    "Repeat one motion of {joint} many times without a pause, and again after a pause of ten minutes. "
    "Friction that changes with temperature recovers in the pause; wear and loose parts do not."
)
SLOW = (
    "Move {joint} slowly over its whole range in both directions, with stops of one second. Friction, "
    "play and forces that depend on the position act there."
)
NEXT_RECORDINGS = {
    "positive_direction": BOTH_DIRECTIONS,
    "negative_direction": BOTH_DIRECTIONS,
    "first_half": PAUSE,
    "second_half": PAUSE,
    "large_acceleration": "Repeat a motion of {joint} at half and at double the speed, with fast reversals. "
    "Errors of inertia grow with the square of the speed; delays, compliance and play act at reversals.",
    "low_speed": SLOW,
    "small_acceleration": SLOW,
    "high_speed": "Repeat a motion of {joint} at half and at double the speed. Drag and limits of the drive "
    "act at high speeds.",
}
"""The recording that separates the causes, by the kind of motion during which the residual is large."""

DEFAULT_RECORDING = (
    "Repeat one motion of {joint} at half the speed, at double the speed, and with a known load. The change "
    "that alters the residual indicates its cause."
)


def name_of_effect(entry: Mapping[str, Any]) -> str:
    """Return the effect in words with its joint or body."""
    words = str(entry["effect"]).removeprefix("joint_").replace("_", " ")
    where = entry["where"] or {}
    return " ".join([words, *(f"at {kind} {name}" for kind, name in where.items())])


def headline(answer: JointAnswer) -> str:
    """Return the verdict as one sentence."""
    if answer["verdict"] == "explained":
        names = join_words([name_of_effect(one) for one in answer["missing"]])
        is_probable = all(one["probability"] >= 0.5 for one in answer["missing"])
        return f"The simulation {'misses' if is_probable else 'may miss'} {names}."
    return PLAIN_VERDICTS[answer["verdict"]]


def residual_sentence(answer: JointAnswer) -> str:
    """Return what remains of the misfit."""
    regime, share = answer["residual"]["regime"], answer["residual"]["share"]
    if answer["verdict"] == "explained":
        found = f"{format_percent(share)} of the misfit remains"
        return f"{found}; it occurs {regime}." if regime else f"{found}."
    if answer["verdict"] == "unexplained":
        return "No tested effect reduces the misfit enough to be named."
    return "The residual is within the noise" + (
        ", apart from the effects below." if answer["immaterial"] else "."
    )


def symptoms(answer: JointAnswer) -> list[tuple[str, str]]:
    """Return terms and descriptions: where, when, how large, what was tried, what to record next.

    The list is empty for verdicts other than "unexplained".
    """
    if answer["verdict"] != "unexplained":
        return []
    shares: dict[str, float] = answer["mismatch"]["joints"]
    ranked = sorted(shares, key=lambda joint: -shares[joint])
    main = [joint for joint in ranked if shares[joint] >= MAIN_SHARE] or ranked[:1]
    regime = str(answer["residual"]["regime"] or "")
    rows = [
        ("where", _where(main, shares)),
        ("when", _when(answer, regime)),
        ("how large", _size(answer, main)),
        ("tried", _tried(answer)),
        ("record next", _next_recording(answer["residual"].get("regime_kind"), main)),
    ]
    return [(name, text) for name, text in rows if text]


def _where(main: list[str], shares: Mapping[str, float]) -> str:
    parts = [f"joint {joint} ({format_percent(shares[joint])} of the misfit)" for joint in main]
    return f"At {join_words(parts)}." if parts else ""


def _when(answer: JointAnswer, regime: str) -> str:
    """Return the regime in which the residual is large, and the time at which it is largest."""
    found = [f"It is larger {regime}."] if regime else []
    windows = answer["mismatch"]["windows"]
    if windows:
        worst = max(windows, key=lambda window: float(window["strength"]))
        at = format_interval(worst["start"], worst["end"])
        times = f"{format_fixed(worst['strength'], 1)} times its RMS"
        found.append(f"It is largest in {worst['episode']} at {at}, joint {worst['joint']} ({times}).")
    return " ".join(found) or "Its size hardly depends on speed, acceleration, direction or time."


def _size(answer: JointAnswer, main: list[str]) -> str:
    sizes, units = answer["residual"]["effort_rms"], answer["residual"]["effort_unit"]
    known = [joint for joint in main if joint in sizes]
    parts = [f"{format_significant(sizes[joint])} {units[joint]} at joint {joint}" for joint in known]
    return f"Missing effort (RMS): {join_words(parts)}." if parts else ""


def _tried(answer: JointAnswer) -> str:
    """Return what was tested, and the closest effect if there is one."""
    text = "Every effect of the catalogue (`trundle effects`) that applies, alone and with others."
    closest = answer["alternatives"][:1]
    return f"{text} Closest: {name_of_effect(closest[0])}." if closest else text


def _next_recording(regime: str | None, main: list[str]) -> str:
    if not main:
        return ""
    return NEXT_RECORDINGS.get(regime or "", DEFAULT_RECORDING).format(joint=f"joint {main[0]}")
