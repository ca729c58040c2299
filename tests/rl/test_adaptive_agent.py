"""The adaptive agent under stable-baselines3. Needs the extra [rl]."""

import re
import subprocess
import sys
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.monitor import Monitor

import trundle

ENVIRONMENT = "trundle/LockedWheel-v0"
ROOT = Path(__file__).resolve().parents[2]


def test_evaluate_policy_reaches_the_goal() -> None:
    environment = Monitor(gym.make(ENVIRONMENT))
    environment.reset(seed=0)
    agent = trundle.AdaptiveAgent(environment)
    rewards, lengths = evaluate_policy(agent, environment, n_eval_episodes=4, return_episode_rewards=True)
    assert max(lengths) < 300
    assert min(rewards) > -5.0


@pytest.mark.parametrize("count", [1, 3])
def test_vectorised_evaluation_learns_in_each_environment(count: int) -> None:
    environments = make_vec_env(ENVIRONMENT, n_envs=count, seed=0)
    agent = trundle.AdaptiveAgent(environments.envs[0])
    ends = []

    def look(local: dict[str, Any], _: dict[str, Any]) -> None:
        if local["done"]:
            ends.append((local["info"]["is_success"], local["states"][local["i"]].fits))

    evaluate_policy(agent, environments, n_eval_episodes=2 * count, callback=look)
    assert np.all([success for success, _ in ends])
    assert min(fits for _, fits in ends) >= 1


def test_the_example_runs() -> None:
    script = [sys.executable, "examples/evaluate_with_sb3.py", "--episodes", "2"]
    printed = subprocess.run(script, cwd=ROOT, capture_output=True, text=True, check=True).stdout
    assert re.match(r"return -\d\.\d\d", printed)
