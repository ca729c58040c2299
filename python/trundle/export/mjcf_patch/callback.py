"""Effects that MJCF cannot express, for the `robot.xml` next to this file.

    model = mujoco.MjModel.from_xml_path("robot.xml")   # or a model that includes it
    data = mujoco.MjData(model)
    effects = Effects(model)
    with effects.installed():                           # for all steps in this block
        mujoco.mj_step(model, data)

`effects.json` holds the parameters; change `effects.entries` to use others. Steps of other models in the same
process are not affected, but MuJoCo loads no model while a Python callback is installed. Needs `mujoco` and
`numpy`.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import mujoco
import numpy as np

HERE = Path(__file__).resolve().parent


class Effects:
    """Forces and dry friction at the joints of a MuJoCo model.

    Parameters
    ----------
    model : mujoco.MjModel
        The patched model. Its dry friction is changed while the callback is installed.
    folder : path
        Folder of `effects.json`.
    """

    def __init__(self, model: mujoco.MjModel, folder: str | Path = HERE) -> None:
        self.model = model
        self.entries: list[dict[str, Any]] = json.loads((Path(folder) / "effects.json").read_text("utf-8"))
        self.friction = model.dof_frictionloss.copy()
        self.largest: dict[int, float] = {}

    @contextmanager
    def installed(self) -> Iterator[None]:
        """Install the effects as MuJoCo's callback of passive forces.

        Afterwards the callback before and the dry friction are restored.
        """
        before = mujoco.get_mjcb_passive()
        mujoco.set_mjcb_passive(self.apply)
        try:
            yield
        finally:
            mujoco.set_mjcb_passive(before)
            self.model.dof_frictionloss[:] = self.friction

    def apply(self, model: mujoco.MjModel, data: mujoco.MjData) -> None:
        """Add forces to `data.qfrc_passive`, and set the dry friction of the next step."""
        if model.signature != self.model.signature:
            return
        friction = self.friction.copy()
        for entry in self.entries:
            dof = int(model.joint(entry["joint"]).dofadr[0])
            law = getattr(self, entry["kind"])
            force, dry = law(entry, model, data, dof)
            data.qfrc_passive[dof if entry["kind"] in DRIVE_SIDE else output(model, entry)] += force
            friction[dof] = max(friction[dof] + dry, 0.0)
        model.dof_frictionloss[:] = friction

    def joint_dry_friction(
        self, entry: dict[str, Any], model: mujoco.MjModel, data: mujoco.MjData, dof: int
    ) -> tuple[float, float]:
        """Return the rise of dry friction at low speed (Stribeck)."""
        share = math.exp(-((data.qvel[dof] / entry["velocity"]) ** 2))
        return 0.0, (entry["static_effort"] - entry["effort"]) * share

    def joint_load_friction(
        self, entry: dict[str, Any], model: mujoco.MjModel, data: mujoco.MjData, dof: int
    ) -> tuple[float, float]:
        """Return dry friction in proportion to the load of the last step."""
        inertial, own, unit = (np.zeros(model.nv) for _ in range(3))
        unit[dof] = 1.0
        mujoco.mj_mulM(model, data, inertial, data.qacc)
        mujoco.mj_mulM(model, data, own, unit)
        external = -data.qfrc_bias[dof] - (inertial[dof] - own[dof] * data.qacc[dof])
        return 0.0, entry["coefficient"] * abs(float(data.qfrc_actuator[dof] - external))

    def joint_directional_friction(
        self, entry: dict[str, Any], model: mujoco.MjModel, data: mujoco.MjData, dof: int
    ) -> tuple[float, float]:
        """Return the part of the friction that differs by direction."""
        viscous, dry = entry.get("viscous_difference", 0.0), entry.get("dry_difference", 0.0)
        return -dry - viscous * abs(float(data.qvel[dof])), 0.0

    def joint_cogging(
        self, entry: dict[str, Any], model: mujoco.MjModel, data: mujoco.MjData, dof: int
    ) -> tuple[float, float]:
        """Return an effort that is periodic in the true position of the joint's output."""
        q = sum(float(data.joint(name).qpos[0]) for name in entry["chain"]) - entry["offset"]
        phase = 2 * math.pi * q / entry["period"] + entry["phase"]
        return entry["amplitude"] * math.sin(phase), 0.0

    def drive_gain_droop(
        self, entry: dict[str, Any], model: mujoco.MjModel, data: mujoco.MjData, dof: int
    ) -> tuple[float, float]:
        """Return the effort that the drive loses, from that of the last step."""
        effort = float(data.qfrc_actuator[dof])
        self.largest[dof] = max(self.largest.get(dof, 1e-9), abs(effort))
        largest = entry.get("max_effort", self.largest[dof])
        return -entry["droop"] * abs(effort) / largest * effort, 0.0


DRIVE_SIDE = ("joint_directional_friction", "drive_gain_droop")
"""Effects at the drive; the others act on the output if the joint has play or compliance."""


def output(model: mujoco.MjModel, entry: dict[str, Any]) -> list[int]:
    """Return the degrees of freedom whose positions add up to that of the joint's output."""
    return [int(model.joint(name).dofadr[0]) for name in entry["chain"]]
