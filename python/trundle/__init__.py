"""Physics-based models of pushed furniture: estimation, diagnosis of missing effects, planning.

The command line is `trundle`; `trundle.cli` describes it.
"""

from trundle import _startup as _startup  # isort: skip  (before slow imports, to handle Ctrl-C)
from importlib import import_module as _import_module
from typing import TYPE_CHECKING as _TYPE_CHECKING

from trundle import objects
from trundle._native import Planner, __version__
from trundle._registration import register_environments as _register_environments
from trundle.design import Design
from trundle.diagnosis import Diagnosis, diagnose
from trundle.episode import Episode
from trundle.experiment_design import design
from trundle.findings import Finding, Findings
from trundle.fitting import Fit, fit
from trundle.identifiability import Profile, profile
from trundle.inspection import check, inspect, prepare, smooth
from trundle.joint_diagnosis import JointDiagnosis
from trundle.joint_episode import JointEpisode
from trundle.joint_summary import JointSummary
from trundle.model import Model, effects, joint_effects
from trundle.online import Online
from trundle.posterior import Posterior, sample
from trundle.prediction import Prediction, predict
from trundle.recording import JointRecording, Recording, TrundleError, read
from trundle.simulation import demo, simulate
from trundle.stream import Stream
from trundle.summary import RecordingSummary

if _TYPE_CHECKING:
    from trundle import baselines, calibration, envs, export, importers, mechanism, plots, report
    from trundle.agent import AdaptiveAgent
    from trundle.agent_settings import AgentSettings
    from trundle.joint_design import JointDesign
    from trundle.record_wrapper import Record
    from trundle.viewing import view

__all__ = [
    "AdaptiveAgent",
    "AgentSettings",
    "Design",
    "Diagnosis",
    "Episode",
    "Finding",
    "Findings",
    "Fit",
    "JointDesign",
    "JointDiagnosis",
    "JointEpisode",
    "JointRecording",
    "JointSummary",
    "Model",
    "Online",
    "Planner",
    "Posterior",
    "Prediction",
    "Profile",
    "Record",
    "Recording",
    "RecordingSummary",
    "Stream",
    "TrundleError",
    "__version__",
    "baselines",
    "calibration",
    "check",
    "demo",
    "design",
    "diagnose",
    "effects",
    "envs",
    "export",
    "fit",
    "importers",
    "inspect",
    "joint_effects",
    "mechanism",
    "objects",
    "plots",
    "predict",
    "prepare",
    "profile",
    "read",
    "report",
    "sample",
    "simulate",
    "smooth",
    "view",
]

_LAZY = {
    "AdaptiveAgent": "trundle.agent",
    "AgentSettings": "trundle.agent_settings",
    "JointDesign": "trundle.joint_design",
    "Record": "trundle.record_wrapper",
    "baselines": "trundle",
    "calibration": "trundle",
    "envs": "trundle",
    "export": "trundle",
    "importers": "trundle",
    "mechanism": "trundle",
    "plots": "trundle",
    "report": "trundle",
    "view": "trundle.viewing",
}
"""Modules of the public names that are imported on first use, because they take long."""

_register_environments()


def __getattr__(name: str) -> object:
    if name not in _LAZY:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    if _LAZY[name] == __name__:
        return _import_module(f"{__name__}.{name}")
    value = getattr(_import_module(_LAZY[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*__all__, *(name for name in globals() if name.startswith("__"))]
