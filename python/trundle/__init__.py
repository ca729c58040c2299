"""Physics-based models of pushed furniture: estimation, diagnosis of missing effects, planning.

The command line is `trundle`; `trundle.cli` describes it.
"""

from trundle import _startup as _startup  # isort: skip  (before slow imports, to handle Ctrl-C)
from importlib import import_module as _import_module
from typing import TYPE_CHECKING as _TYPE_CHECKING

from trundle import baselines, envs, objects
from trundle._native import Planner, __version__
from trundle.agent import AdaptiveAgent
from trundle.design import Design, design
from trundle.diagnosis import Diagnosis, Fit, diagnose, fit
from trundle.episode import Episode
from trundle.findings import Finding, Findings
from trundle.identifiability import Profile, profile
from trundle.inspection import check, inspect, prepare, smooth
from trundle.model import Model, effects
from trundle.online import Online
from trundle.posterior import Posterior, sample
from trundle.prediction import Prediction, predict
from trundle.record_wrapper import Record
from trundle.recording import Recording, TrundleError, read
from trundle.simulation import simulate
from trundle.stream import Stream
from trundle.summary import RecordingSummary

if _TYPE_CHECKING:
    from trundle import calibration, export, importers, report

__all__ = [
    "AdaptiveAgent",
    "Design",
    "Diagnosis",
    "Episode",
    "Finding",
    "Findings",
    "Fit",
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
    "design",
    "diagnose",
    "effects",
    "envs",
    "export",
    "fit",
    "importers",
    "inspect",
    "objects",
    "predict",
    "prepare",
    "profile",
    "read",
    "report",
    "sample",
    "simulate",
    "smooth",
]

_LAZY = {
    "calibration": "trundle",
    "export": "trundle",
    "importers": "trundle",
    "plots": "trundle",
    "report": "trundle",
}
"""Modules of the public names that are imported on first use."""


def __getattr__(name: str) -> object:
    if name not in _LAZY:
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    return _import_module(f"{__name__}.{name}")


def __dir__() -> list[str]:
    return [*__all__, *(name for name in globals() if name.startswith("__"))]
