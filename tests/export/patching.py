"""A two-joint arm whose model is patched."""

from __future__ import annotations

from pathlib import Path

from trundle.export import write_mjcf_patch
from trundle.mechanism import JointEffect, MechanismModel, MechanismTable

ROBOT = """<mujoco>
<compiler inertiafromgeom="true"/>
<option timestep="0.001" integrator="implicitfast"/>
<default><default class="arm"><joint axis="0 1 0" damping="0.2" armature="0.03"/></default></default>
<worldbody>
  <geom type="box" size="0.1 0.1 0.01" contype="0" conaffinity="0"/>
  <body name="upper">
    <joint name="shoulder" class="arm" range="-170 170" stiffness="2" springref="10"/>
    <geom type="capsule" fromto="0 0 0 0.3 0 0" size="0.03" mass="1.5" contype="0"/>
    <body name="lower" pos="0.3 0 0">
      <joint name="elbow" class="arm" ref="20"/>
      <geom type="capsule" fromto="0 0 0 0.25 0 0" size="0.02" mass="0.7" contype="0"/>
      <body name="tool" pos="0.25 0 0"><geom size="0.03" mass="0.2" contype="0"/></body>
    </body>
  </body>
</worldbody>
<actuator><motor name="upper_motor" joint="shoulder"/></actuator>
<keyframe><key qpos="0 0"/></keyframe>
</mujoco>"""
JOINTS = ["shoulder", "elbow"]


def model(*effects: JointEffect, **nominal: float) -> MechanismModel:
    values = {key.replace("__", ":"): value for key, value in nominal.items()}
    return MechanismModel(MechanismTable(JOINTS, "robot.xml"), values, list(effects))


def effect(kind: str, where: str | None = "elbow", **parameters: float) -> JointEffect:
    if kind == "payload":
        return JointEffect(kind, body=where, parameters=parameters)
    return JointEffect(kind, joint=where, parameters=parameters)


def patched(tmp_path: Path, described: MechanismModel, text: str = ROBOT) -> Path:
    (tmp_path / "source").mkdir(exist_ok=True)
    (tmp_path / "source" / "robot.xml").write_text(text)
    described.write(tmp_path / "source" / "model.toml")
    return write_mjcf_patch(tmp_path / "source" / "model.toml", tmp_path / "exports" / "patched")
