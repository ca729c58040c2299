"""Designed experiments for the alternatives of a diagnosis."""

from __future__ import annotations

from trundle._native import JointRecording, TrundleError
from trundle._types import JointAnswer
from trundle.joint_design.designing import design_joints

__all__ = ["design_alternatives"]

MAX_DESIGNED = 2
"""Alternatives whose experiment is designed; each takes a few tenths of a second."""


def design_alternatives(answer: JointAnswer, recording: JointRecording) -> None:
    """Replace the general advice of the most probable alternatives by designed experiments, in place.

    This happens for an axis without a model with one missing effect, whose designs are fast. Other
    alternatives keep the advice of the catalogue.
    """
    if "axis" not in recording.metadata["mechanism"] or len(answer["missing"]) != 1:
        return
    named = _name(answer["missing"][0])
    for alternative in answer["alternatives"][:MAX_DESIGNED]:
        try:
            design = design_joints(named, _name(alternative), recording, progress=False)
        except TrundleError:  # such as an axis without a drive: the advice of the catalogue remains
            continue
        alternative["experiment"] = design.sentence


def _name(effect: dict[str, object]) -> str:
    where = effect["where"]
    return ":".join([str(effect["effect"]), *(where.values() if isinstance(where, dict) else ())])
