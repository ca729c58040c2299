"""Diagnosis of recordings of joints: which physics a mechanism's model misses."""

from __future__ import annotations

from trundle.joint_diagnosis.engine import diagnose_joints
from trundle.joint_diagnosis.log import open_joints, read_log
from trundle.joint_diagnosis.result import JointDiagnosis

__all__ = ["JointDiagnosis", "diagnose_joints", "open_joints", "read_log"]


def __dir__() -> list[str]:
    return __all__
