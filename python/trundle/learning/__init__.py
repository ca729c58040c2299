"""Learning agents: what stable-baselines3 learns on the tasks, and its policies without it.

To train needs the extra `trundle[rl]`; `trundle.learning.policy` reads and runs a policy with NumPy alone.
"""
