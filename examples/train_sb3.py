"""Train stable-baselines3's PPO for a few steps on a level, and evaluate it on objects of the test set.

python examples/train_sb3.py --steps 20000
"""

import argparse

import gymnasium
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.evaluation import evaluate_policy

import trundle  # noqa: F401 (registers the environments)

parser = argparse.ArgumentParser()
parser.add_argument("--steps", type=int, default=20_000, help="steps of all environments together")
steps = parser.parse_args().steps

torch.set_num_threads(1)  # more threads are slower with such small networks
LEVEL = "trundle/PushAroundEasy-v1"
envs = make_vec_env(LEVEL, n_envs=4, seed=0)
learner = PPO("MlpPolicy", envs, n_steps=256, device="cpu")
learner.learn(steps)
unseen = gymnasium.make(LEVEL, split="test")
mean, spread = evaluate_policy(learner, unseen, n_eval_episodes=5, warn=False)
print(f"return on unseen objects after {steps} steps: {mean:.1f} ± {spread:.1f}")
