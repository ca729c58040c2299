"""Changes of the rig: loads, pose of the base, side of the encoder, covariates of the friction."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from trundle._native import JointRecording, TrundleError
from trundle.display.fields import DisplayedFields
from trundle.joint_diagnosis.signals import read_signals
from trundle.joint_diagnosis.under_test import COMPLIANT
from trundle.mechanism.loading import Payload

if TYPE_CHECKING:
    from trundle.joint_diagnosis.mechanisms import EpisodeMechanisms

__all__ = ["AS_RECORDED", "AxisLoad", "Rig", "changed_rigs", "covariate_rigs", "given_rigs"]

PAYLOAD_SHARE = 0.5
"""Mass of a default payload, as a share of the mass of the body that carries it."""
QUARTER_TURN = float(np.pi / 2)
MIN_COVARIATE_SPREAD = 0.05
"""Range of a covariate, as a share of its largest size, from which its ends are other conditions."""


@dataclass(frozen=True, repr=False)
class AxisLoad(DisplayedFields):
    """A known load that is added to an axis without a model.

    Attributes
    ----------
    gravity_torque : float
        Largest torque by which the load resists at sin q = 1, N·m; 0 on a slide.
    inertia : float
        Inertia about the axis, kg·m², or mass, kg.
    effort : float
        Constant effort against which the axis moves, such as a weight over a pulley, N·m or N.

    Examples
    --------
    >>> from trundle.joint_design import AxisLoad
    >>> AxisLoad(gravity_torque=0.5, inertia=0.01).inertia
    0.01
    """

    gravity_torque: float = 0.0
    inertia: float = 0.0
    effort: float = 0.0


@dataclass(frozen=True)
class Rig:
    """A rig on which a trajectory is played.

    Attributes
    ----------
    kind : str
        "as_recorded", "payload", "axis_load", "gravity", "inertia", "base", "encoder" or "covariate".
    words : str
        Description; empty for the recorded rig.
    load : dict, optional
        Change of an axis: keys as in `trundle._native`'s separation.
    payload : Payload, optional
    tilt : tuple of two floats, optional
        Turn of gravity about the world's x and y axis, rad.
    covariates : dict
        Value of `load_JOINT` by joint.
    other_encoder : bool
        Whether encoders are on the other side of the gears.
    adds_load : bool
        Whether the drive needs more effort than recorded.
    """

    kind: str = "as_recorded"
    words: str = ""
    load: Mapping[str, float] | None = None
    payload: Payload | None = None
    tilt: tuple[float, float] | None = None
    covariates: Mapping[str, float] = field(default_factory=dict)
    other_encoder: bool = False
    adds_load: bool = False

    @property
    def needs_model(self) -> bool:
        """Whether the dynamics of the model change."""
        return self.payload is not None or self.tilt is not None


AS_RECORDED = Rig()


def covariate_rigs(recording: JointRecording) -> list[Rig]:
    """Return the recorded conditions: one, or the ends of the range of a recorded covariate."""
    spans: dict[str, tuple[float, float]] = {}
    for name, episode in recording.items():
        for joint in recording.joints:
            if episode.held_out or f"load_{joint}" not in episode:
                continue
            t, _ = episode.stream("q", joint)
            load = read_signals(recording, name, joint, t).load
            if load is not None:
                low, high = spans.get(joint, (np.inf, -np.inf))
                spans[joint] = (min(low, float(load.min())), max(high, float(load.max())))
    if not spans:
        return [AS_RECORDED]
    middle = {joint: (low + high) / 2 for joint, (low, high) in spans.items()}
    found = [Rig(covariates=middle)]
    for joint, ends in spans.items():
        if ends[1] - ends[0] < MIN_COVARIATE_SPREAD * max(map(abs, ends)):
            continue
        for end in ends:
            words = f"with load_{joint} = {end:.3g} as recorded"
            found.append(Rig("covariate", words, covariates={**middle, joint: end}))
    return found


def given_rigs(loads: Sequence[AxisLoad | Payload], *, has_model: bool) -> list[Rig]:
    """Return rigs with loads that the user gave.

    Raises
    ------
    TrundleError
        If a load is not of the kind that the mechanism needs.
    """
    found = []
    for load in loads:
        if isinstance(load, Payload) != has_model:
            wanted = "a Payload on a body" if has_model else "an AxisLoad"
            raise TrundleError(f"loads: {load!r}: give {wanted} for this recording")
        if isinstance(load, Payload):
            found.append(_payload_rig(load))
            continue
        values = {key: value for key, value in asdict(load).items() if value}
        if not values or not np.isfinite(list(values.values())).all():
            raise TrundleError(f"loads: {load!r}: give at least one finite value that is not zero")
        words = ", ".join(f"{key.replace('_', ' ')} {value:.3g}" for key, value in values.items())
        found.append(Rig("axis_load", f"with an added load ({words})", load=values, adds_load=True))
    return found


def changed_rigs(
    recording: JointRecording,
    mechanisms: EpisodeMechanisms | None,
    effects: Sequence[str],
    effort: float,
) -> list[Rig]:
    """Return changes of the rig that are tried where the recorded rig cannot tell.

    Parameters
    ----------
    recording : JointRecording
    mechanisms : EpisodeMechanisms, optional
        Of a mechanism with a model.
    effects : sequence of str
        Names of the effects of both explanations.
    effort : float
        Recorded effort of an axis, for a pull that has its size.
    """
    found = _axis_rigs(recording, effort) if mechanisms is None else _model_rigs(mechanisms)
    for rig in covariate_rigs(recording):
        found += [
            Rig(
                "covariate",
                f"with load_{joint} = {2 * value:.3g}",
                covariates={**rig.covariates, joint: 2 * value},
            )
            for joint, value in rig.covariates.items()
        ]
    if any(name.partition(":")[0] in COMPLIANT for name in effects):
        found.append(Rig("encoder", "with the encoder on the other side of the gear", other_encoder=True))
    return found


def _axis_rigs(recording: JointRecording, effort: float) -> list[Rig]:
    table = recording.metadata["mechanism"]
    if table.get("gravity") or "gravity_torque" in table:
        return [
            Rig(
                "axis_load",
                "with the same load attached a second time",
                load={"gravity_factor": 2.0, "inertia_factor": 2.0},
                adds_load=True,
            ),
            Rig(
                "gravity",
                "with the axis vertical, so that gravity does not load it",
                load={"gravity_factor": 0.0},
            ),
        ]
    doubled = "with the moved mass doubled" if table["axis"] == "slide" else "with the inertia doubled"
    pull = f"against a constant pull of {effort:.3g}, such as a weight over a pulley"
    return [
        Rig("inertia", doubled, load={"inertia_factor": 2.0}, adds_load=True),
        Rig("axis_load", pull, load={"effort": effort}, adds_load=True),
    ]


def _model_rigs(mechanisms: EpisodeMechanisms) -> list[Rig]:
    first = mechanisms.first
    group = first.groups[-1]
    mass, *moment = group.parameters[:4]
    x, y, z = (float(each / mass) for each in moment) if mass > 0 else (0.0, 0.0, 0.0)
    payload = Payload(group.name, float(PAYLOAD_SHARE * group.mass), (x, y, z))
    found = [_payload_rig(payload)] if payload.mass > 0 else []
    for axis, tilt in (("x", (QUARTER_TURN, 0.0)), ("y", (0.0, QUARTER_TURN))):
        words = f"with the base turned by a quarter turn about the world's {axis} axis"
        found.append(Rig("base", words, tilt=tilt, adds_load=True))
    return found


def _payload_rig(payload: Payload) -> Rig:
    place = ", ".join(f"{each:.3g}" for each in payload.com)
    words = f"with a payload of {payload.mass:.3g} kg on {payload.body} at ({place}) m"
    return Rig("payload", words, payload=payload, adds_load=True)
