"""Push what you have never seen: physics-based models of wheeled furniture, learnt, diagnosed and used."""

from trundle.recording import Recording, TrundleError, read

__all__ = ["Recording", "TrundleError", "read"]
