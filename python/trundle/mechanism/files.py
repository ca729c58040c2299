"""Model files of mechanisms (`trundle-model/2`): refitted values, missing effects and their posterior."""

from __future__ import annotations

import math
import os
import sys
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Annotated, Any, Literal

import tomli_w

from trundle._native import TrundleError
from trundle.atomic import write_text
from trundle.display.fields import DisplayedFields
from trundle.rules import Rule
from trundle.settings import SettingsError, typed

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

__all__ = ["JointEffect", "MechanismModel", "MechanismTable", "Posterior"]

FORMAT = "trundle-model/2"
Finite = Annotated[float, Rule(math.isfinite, "a finite number")]


@dataclass(frozen=True, repr=False)
class MechanismTable(DisplayedFields):
    """The table `[mechanism]`, as in a recording: an MJCF or URDF model, one axis, or joints of a simulator.

    Attributes
    ----------
    joints : list of str
        The recorded joints.
    model : str, optional
        The MJCF or URDF file.
    free : list of str, optional
        What may be refitted.
    axis : {"hinge", "slide"}, optional
        An axis without a model.
    types : {"hinge", "slide"} or dict, optional
        Types of the joints, for all or by joint, of the user's own simulator.
    imposed, gravity : bool
        Whether the motion is imposed, and whether a gravity torque is part of an axis.
    inertia, gravity_torque : float, optional
        Known values of an axis.

    Examples
    --------
    >>> from trundle.mechanism import MechanismTable
    >>> MechanismTable(joints=["elbow"], model="robot.xml").model
    'robot.xml'
    """

    joints: list[str]
    model: str | None = None
    free: list[str] | None = None
    axis: Literal["hinge", "slide"] | None = None
    types: Literal["hinge", "slide"] | dict[str, Literal["hinge", "slide"]] | None = None
    imposed: bool = False
    inertia: Finite | None = None
    gravity: bool = False
    gravity_torque: Finite | None = None

    def __post_init__(self) -> None:
        if sum(each is not None for each in (self.model, self.axis, self.types)) != 1:
            raise SettingsError("give either `model`, an MJCF or URDF file, or `axis`, or `types`")


@dataclass(frozen=True, repr=False)
class JointEffect(DisplayedFields):
    """A missing effect.

    Attributes
    ----------
    kind : str
        Its name in the catalogue.
    joint, body : str, optional
        Where it acts; neither for an effect on the whole mechanism.
    parameters : dict of str to float
        In SI units.

    Examples
    --------
    >>> from trundle.mechanism import JointEffect
    >>> JointEffect("joint_dry_friction", joint="elbow", parameters={"effort": 1.2}).name
    'joint_dry_friction:elbow'
    """

    kind: str
    joint: str | None = None
    body: str | None = None
    parameters: dict[str, Finite] = field(default_factory=dict)

    @property
    def name(self) -> str:
        """The kind with the joint or body: "joint_dry_friction:elbow"."""
        where = self.joint or self.body
        return f"{self.kind}:{where}" if where else self.kind


@dataclass(frozen=True, repr=False)
class Posterior(DisplayedFields):
    """Normal approximation of the posterior of the fitted parameters.

    Attributes
    ----------
    names : list of str
        Keys of `[nominal]`, and "KIND:WHERE.PARAMETER" for effects.
    mean : list of float
    covariance : list of list of float

    Examples
    --------
    >>> from trundle.mechanism import Posterior
    >>> Posterior(["damping:elbow"], [0.8], [[0.01]]).deviations()
    {'damping:elbow': 0.1}
    """

    names: list[str]
    mean: list[Finite]
    covariance: list[list[Finite]]

    def __post_init__(self) -> None:
        n = len(self.names)
        if len(self.mean) != n or len(self.covariance) != n or any(len(row) != n for row in self.covariance):
            raise SettingsError(f"{n} names need {n} means and {n} rows of {n} covariances")
        if any(self.covariance[k][k] < 0 for k in range(n)):
            raise SettingsError("variances must not be negative")

    def deviations(self) -> dict[str, float]:
        """Return the standard deviations by name."""
        return {name: math.sqrt(self.covariance[k][k]) for k, name in enumerate(self.names)}


@dataclass(frozen=True, repr=False)
class MechanismModel(DisplayedFields):
    """A model file.

    Attributes
    ----------
    mechanism : MechanismTable
    nominal : dict of str to float
        Refitted values by "PARAMETER:NAME", such as "armature:elbow" or "mass:forearm".
    effect : list of JointEffect
        The missing effects; their parameters are in addition to what the model has.
    posterior : Posterior, optional

    Examples
    --------
    >>> from trundle.mechanism import MechanismModel
    >>> text = '''
    ... format = "trundle-model/2"
    ... [mechanism]
    ... model = "robot.xml"
    ... joints = ["elbow"]
    ... [nominal]
    ... "damping:elbow" = 0.8
    ... [[effect]]
    ... kind = "joint_dry_friction"
    ... joint = "elbow"
    ... effort = 1.2
    ... '''
    >>> model = MechanismModel.from_toml(text)
    >>> model.nominal, model.effect[0].parameters
    ({'damping:elbow': 0.8}, {'effort': 1.2})
    """

    mechanism: MechanismTable
    nominal: dict[str, Finite] = field(default_factory=dict)
    effect: list[JointEffect] = field(default_factory=list)
    posterior: Posterior | None = None

    @classmethod
    def read(cls, path: str | os.PathLike[str]) -> MechanismModel:
        """Read a file.

        Raises
        ------
        TrundleError
            If it is not a `trundle-model/2` file: the message names the key and the remedy.
        """
        try:
            text = Path(path).read_text(encoding="utf-8")
        except FileNotFoundError as error:
            raise TrundleError(f"{path}: no such file") from error
        except UnicodeDecodeError as error:
            raise TrundleError(f"{path}: not a TOML file: {error}") from error
        return cls.from_toml(text, os.fspath(path))

    @classmethod
    def from_toml(cls, text: str, name: str = "model.toml") -> MechanismModel:
        """Parse the text of a file; `name` names it in messages."""
        try:
            table = tomllib.loads(text)
        except tomllib.TOMLDecodeError as error:
            raise TrundleError(f"{name}: not a TOML file: {error}") from error
        if table.pop("format", None) != FORMAT:
            raise TrundleError(f'{name}: must begin with format = "{FORMAT}"')
        try:
            if isinstance(table.get("effect"), list):
                table["effect"] = [_nested(entry) for entry in table["effect"]]
            return typed(cls, table)
        except SettingsError as error:
            raise TrundleError(f"{name}: {error}") from error

    def to_toml(self) -> str:
        """Return the text of the file; keys with default values are omitted."""
        table: dict[str, Any] = {"format": FORMAT, "mechanism": _given(asdict(self.mechanism))}
        if self.nominal:
            table["nominal"] = dict(self.nominal)
        if self.effect:
            table["effect"] = [
                _given({"kind": one.kind, "joint": one.joint, "body": one.body}) | one.parameters
                for one in self.effect
            ]
        if self.posterior is not None:
            table["posterior"] = asdict(self.posterior)
        return tomli_w.dumps(table)

    def write(self, path: str | os.PathLike[str]) -> None:
        """Write the file atomically."""
        write_text(Path(path), self.to_toml())


def _nested(entry: Any) -> Any:
    """Return an entry of `[[effect]]` with its parameters in a table of their own."""
    if not isinstance(entry, Mapping):
        return entry
    own = {key: value for key, value in entry.items() if key in ("kind", "joint", "body")}
    return own | {"parameters": {key: value for key, value in entry.items() if key not in own}}


def _given(table: Mapping[str, Any]) -> dict[str, Any]:
    """Return the entries that differ from the defaults, which are None and false."""
    return {key: value for key, value in table.items() if value is not None and value is not False}
