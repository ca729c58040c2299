"""Training of policies with stable-baselines3, and their evaluation.

Training needs the extra `trundle[rl]`. `trundle.experiments.training.policy` reads and runs a policy with
NumPy only.
"""
