"""Learning agents: what stable-baselines3 learns on the tasks, and its policies without it.

Training needs the extra `trundle[rl]`. `trundle.experiments.training.policy` reads and runs a policy with
NumPy alone.
"""
