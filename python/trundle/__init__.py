"""Push what you have never seen: physics-based models of wheeled furniture, learnt, diagnosed and used."""

from trundle._native import __version__
from trundle.diagnosis import Diagnosis, Fit, diagnose, fit, predict
from trundle.model import Model, effects
from trundle.recording import Recording, TrundleError, read

__all__ = [
    "Diagnosis",
    "Fit",
    "Model",
    "Recording",
    "TrundleError",
    "__version__",
    "diagnose",
    "effects",
    "fit",
    "predict",
    "read",
]
