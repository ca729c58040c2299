"""Evaluate the adaptive agent with stable-baselines3 (requires the extra [rl]).

python examples/evaluate_with_sb3.py --episodes 10
"""

import argparse

import numpy as np
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.evaluation import evaluate_policy

import trundle

parser = argparse.ArgumentParser()
parser.add_argument("--episodes", type=int, default=10)
episodes = parser.parse_args().episodes

# The agent reads the action space and the footprint of the table from one of the environments.
envs = make_vec_env("trundle/LockedWheel-v0", n_envs=2, seed=0)
agent = trundle.AdaptiveAgent(envs.envs[0])

# evaluate_policy passes an observation of each environment, the beliefs of the previous step, and flags for
# new episodes. The agent restarts from its first model in each episode, because the wheel changes.
rewards, lengths = evaluate_policy(agent, envs, n_eval_episodes=episodes, return_episode_rewards=True)
print(f"return {np.mean(rewards):.2f} ± {np.std(rewards):.2f}, {0.05 * np.mean(lengths):.1f} s per episode")
