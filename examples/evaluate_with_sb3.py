"""Evaluate the adaptive agent as stable-baselines3 evaluates its own (needs the extra [rl]).

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

# The agent looks at one of the environments for what it may know: the action space and the table's outline.
envs = make_vec_env("trundle/LockedWheel-v0", n_envs=2, seed=0)
agent = trundle.AdaptiveAgent(envs.envs[0])

# evaluate_policy hands over an observation of each environment, the beliefs from the step before and where an
# episode begins; there the agent starts over, for the wheel is another one.
rewards, lengths = evaluate_policy(agent, envs, n_eval_episodes=episodes, return_episode_rewards=True)
print(f"return {np.mean(rewards):.2f} ± {np.std(rewards):.2f}, {0.05 * np.mean(lengths):.1f} s an episode")
