"""The environments under stable-baselines3. Needs the extra [rl]."""

import subprocess
import sys
import warnings

import gymnasium as gym
import numpy as np
import pytest
import torch
from stable_baselines3 import PPO
from stable_baselines3.common.env_checker import check_env
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.monitor import Monitor

import trundle

ENVIRONMENT = "trundle:trundle/LockedWheel-v0"
REGISTERED = [env_id for env_id, spec in gym.registry.items() if spec.namespace == trundle.__name__]


@pytest.mark.parametrize("action", ["wrench", "velocity", "push", "regrasp"])
@pytest.mark.parametrize("env_id", REGISTERED)
def test_all_environments_pass_the_check(env_id: str, action: str) -> None:
    env = gym.make(env_id, action=action).unwrapped
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        check_env(env)


def test_the_number_of_environments() -> None:
    # Nine in two versions, and three levels of four tasks.
    assert len(REGISTERED) == 2 * 9 + 3 * 4


def test_a_policy_is_trained_and_evaluated() -> None:
    environments = make_vec_env(ENVIRONMENT, n_envs=2, seed=0)
    policy = PPO("MlpPolicy", environments, n_steps=64, batch_size=64, n_epochs=1, seed=0, device="cpu")
    before = policy.policy.state_dict()["action_net.bias"].clone()
    policy.learn(128)
    assert not torch.equal(before, policy.policy.state_dict()["action_net.bias"])
    rewards, lengths = evaluate_policy(
        policy, Monitor(gym.make(ENVIRONMENT)), n_eval_episodes=2, return_episode_rewards=True
    )
    assert np.all(np.isfinite(rewards))
    assert all(0 < length <= 300 for length in lengths)


def test_the_end_of_an_episode_follows_vector_environments() -> None:
    environments = make_vec_env(ENVIRONMENT, n_envs=1, seed=0)
    environments.reset()
    for _ in range(300):
        _, _, done, infos = environments.step(np.zeros((1, 3), dtype=np.float32))
        if done[0]:
            break
    assert infos[0]["TimeLimit.truncated"]
    assert infos[0]["terminal_observation"].shape == (16,)
    assert infos[0]["episode"]["l"] == 300
    assert not infos[0]["is_success"]


def test_the_package_itself_does_not_import_torch() -> None:
    script = "import trundle, sys; sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", script]).returncode == 0
