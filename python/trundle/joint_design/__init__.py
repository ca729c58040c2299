"""Discriminating experiments of mechanisms: trajectories and loads that separate two models."""

from __future__ import annotations

from trundle.joint_design.alternatives import design_alternatives
from trundle.joint_design.designing import design_joints
from trundle.joint_design.result import DesignedTrajectory, JointDesign
from trundle.joint_design.rigs import AxisLoad

__all__ = ["AxisLoad", "DesignedTrajectory", "JointDesign", "design_alternatives", "design_joints"]


def __dir__() -> list[str]:
    return __all__
