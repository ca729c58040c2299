"""Learned dynamics: an ensemble of networks that predicts the motion of an object from its past motion.

`model`, `motion` and `learner` need NumPy only; training needs the extra `trundle[rl]`.
"""
