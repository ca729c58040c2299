"""Physics-based models of pushed furniture: estimation, diagnosis of missing effects, planning.

The command line is `trundle`; `trundle.cli` describes it.
"""

from trundle import _startup as _startup  # isort: skip  (before slow imports, to handle Ctrl-C)
from trundle import baselines, envs, objects, plots
from trundle._native import Planner, __version__
from trundle.agent import AdaptiveAgent
from trundle.design import Design, design
from trundle.diagnosis import Diagnosis, Fit, diagnose, fit, predict
from trundle.identifiability import Profile, profile
from trundle.inspection import check, inspect, prepare, smooth
from trundle.model import Model, effects
from trundle.online import Online
from trundle.posterior import Posterior, sample
from trundle.record_wrapper import Record
from trundle.recording import Recording, TrundleError, read
from trundle.simulation import simulate
from trundle.viewing import view

__all__ = [
    "AdaptiveAgent",
    "Design",
    "Diagnosis",
    "Fit",
    "Model",
    "Online",
    "Planner",
    "Posterior",
    "Profile",
    "Record",
    "Recording",
    "TrundleError",
    "__version__",
    "baselines",
    "check",
    "design",
    "diagnose",
    "effects",
    "envs",
    "fit",
    "inspect",
    "objects",
    "plots",
    "predict",
    "prepare",
    "profile",
    "read",
    "sample",
    "simulate",
    "smooth",
    "view",
]
