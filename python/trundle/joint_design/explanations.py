"""The two explanations of a design: model files, or names of effects."""

from __future__ import annotations

import os
from pathlib import Path

from trundle._native import JointRecording, Model, TrundleError
from trundle.mechanism.files import MechanismModel

__all__ = ["Explanation", "name_explanations", "parse_explanation"]

Effect = tuple[str, dict[str, float]]
"""Name of an effect, "KIND:WHERE", and starting values of its parameters."""
Explanation = MechanismModel | Model | str | os.PathLike[str]

NOMINAL = "nominal"
"""Name of the explanation without effects."""


def parse_explanation(given: Explanation, recording: JointRecording) -> list[Effect]:
    """Return the effects of an explanation.

    Parameters
    ----------
    given : MechanismModel, path or str
        A model file, "nominal", or names of effects joined by "+": "joint_dry_friction:elbow".
    recording : JointRecording

    Raises
    ------
    TrundleError
        If a file is not a `trundle-model/2` file of the recorded joints.
    """
    if isinstance(given, Model):
        raise TrundleError(
            f"{recording.name}: is a recording of joints, but the model is one of a pushed object; give a "
            "trundle-model/2 file or the name of an effect"
        )
    if not isinstance(given, MechanismModel):
        text = os.fspath(given)
        if not Path(text).exists() and not text.endswith(".toml"):
            names = [name.strip() for name in text.split("+")]
            if "" in names:
                raise TrundleError(f"{text!r}: give a model file, or effects joined by +, or {NOMINAL!r}")
            return [] if names == [NOMINAL] else [(name, {}) for name in names]
        given = MechanismModel.read(text)
    joints = given.mechanism.joints
    if set(joints) != set(recording.joints):
        raise TrundleError(
            f"the model has the joints {', '.join(joints)}, the recording {recording.name} has "
            f"{', '.join(recording.joints)}; give models of the recorded mechanism"
        )
    return [(one.name, dict(one.parameters)) for one in given.effect]


def name_explanations(first: list[str], second: list[str]) -> tuple[str, str]:
    """Return names: the effects that only one explanation has."""
    own, other = ([name for name in a if name not in b] for a, b in ((first, second), (second, first)))
    names = [" + ".join(effects) for effects in (own, other)]
    if not own:
        return f"a model without {names[1]}", names[1]
    return names[0], names[1] if other else f"a model without {names[0]}"
