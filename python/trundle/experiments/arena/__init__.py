"""Adaptive agents on gym-pusht, a published benchmark, with hidden physics."""
