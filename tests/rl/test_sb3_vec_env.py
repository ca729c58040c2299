"""A batch under stable-baselines3. Needs the extra [rl]."""

import subprocess
import sys
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
import torch
from gymnasium.vector import VectorWrapper
from gymnasium.wrappers.vector import RecordEpisodeStatistics
from numpy.typing import NDArray
from stable_baselines3 import PPO, SAC, HerReplayBuffer
from stable_baselines3.common.env_util import make_vec_env
from stable_baselines3.common.evaluation import evaluate_policy
from stable_baselines3.common.monitor import Monitor
from stable_baselines3.common.vec_env import VecMonitor, VecNormalize

import trundle
from trundle.envs import PushVec, VectorOracle
from trundle.envs.sb3 import SB3VecEnv

POSE = "trundle/PushPose-v0"
GOAL = "trundle/PushPoseGoal-v0"
TINY = {"net_arch": [16]}
CENTRE = {"start": [0.0, 0.0, 0.0]}


def random_actions(count: int, steps: int, width: int = 3) -> NDArray[np.float32]:
    return np.random.default_rng(0).uniform(-1, 1, (steps, count, width)).astype(np.float32)


def same(one: Any, other: Any) -> bool:
    if isinstance(one, dict):
        return one.keys() == other.keys() and all(same(one[key], other[key]) for key in one)
    if isinstance(one, np.ndarray):
        return one.dtype == other.dtype and np.array_equal(one, other)
    return type(one) is type(other) and bool(one == other)


@pytest.mark.parametrize("env_id", [POSE, GOAL, "trundle/PushPath-v0", "trundle/PushDoorGoal-v0"])
@pytest.mark.parametrize("action", ["wrench", "push", "regrasp"])
def test_the_batch_agrees_with_make_vec_env(env_id: str, action: str) -> None:
    options = {"action": action, "horizon": 40}
    batch = SB3VecEnv.make(env_id, 3, **options)
    singles = make_vec_env(env_id, 3, env_kwargs=options)
    assert batch.observation_space == singles.observation_space
    assert batch.action_space == singles.action_space
    assert batch.seed(7) == singles.seed(7) == [7, 8, 9]
    assert same(batch.reset(), singles.reset())
    assert batch.reset_infos == singles.reset_infos
    ends = 0
    for actions in random_actions(3, 100, 6 if action == "regrasp" else 3):
        observations, rewards, dones, infos = batch.step(actions)
        expected = singles.step(actions)
        for own, other in zip((observations, rewards, dones), expected, strict=False):
            assert same(own, other)
        for info, single in zip(infos, expected[3], strict=True):
            single.pop("episode", None)
            assert same(info, single)
        ends += int(dones.sum())
    assert ends >= 6


def test_the_terminal_observation_is_the_last_of_the_episode() -> None:
    batch, single = SB3VecEnv.make(POSE, 2, horizon=5), gym.make(POSE, horizon=5)
    batch.seed(3)
    batch.reset()
    single.reset(seed=4)
    for step, actions in enumerate(random_actions(2, 5)):
        observations, _, dones, infos = batch.step(actions)
        last, _, _, truncated, info = single.step(actions[1])
        assert dones.tolist() == [step == 4] * 2
    assert truncated
    assert np.array_equal(infos[1]["terminal_observation"], last)
    assert infos[1]["is_success"] is info["is_success"] is False
    assert not np.array_equal(observations[1], last)
    assert np.array_equal(observations[1], single.reset()[0])


@pytest.mark.parametrize("reached", [True, False])
def test_truncation_differs_from_termination(reached: bool) -> None:
    batch = SB3VecEnv.make(POSE, 2, horizon=2)
    batch.set_options([{**CENTRE, "goal": [0.0 if reached else 1.0, 0.0, 0.0]}, {}])
    batch.reset()
    infos = [batch.step(np.zeros((2, 3)))[3][0] for _ in range(2)]
    assert [info["TimeLimit.truncated"] for info in infos] == [False, not reached]
    assert infos[0]["is_success"] is reached


def test_returned_arrays_do_not_change() -> None:
    batch = SB3VecEnv.make(POSE, 2, copy=False, horizon=2)
    kept = [batch.reset()] + [batch.step(actions)[0] for actions in random_actions(2, 4)]
    assert len(np.unique(np.array(kept)[:, 0, 0])) == 5


def test_seeds_and_options_apply_once() -> None:
    batch = SB3VecEnv.make(POSE, 3)
    batch.seed(0)
    first = batch.reset()
    assert not np.array_equal(batch.reset(), first)
    batch.seed(0)
    batch.set_options({"goal": [0.5, 0.25, 0.0]})
    observations = batch.reset()
    assert np.array_equal(observations[:, :7], first[:, :7])
    assert np.array_equal(observations[:, 7:9], [[0.5, 0.25]] * 3)
    assert not np.any(batch.reset()[:, 7] == 0.5)


def test_options_may_differ() -> None:
    batch = SB3VecEnv.make(POSE, 3)
    batch.seed(0)
    first = batch.reset()
    batch.seed(0)
    batch.set_options([{"goal": [0.5, 0.0, 0.0]}, {}, {"goal": [0.25, 0.0, 0.0]}])
    observations = batch.reset()
    assert observations[:, 7].tolist() == [0.5, first[1, 7], 0.25]
    assert np.array_equal(observations[1], first[1])


def test_autoreset_is_refused() -> None:
    with pytest.raises(trundle.TrundleError, match="autoreset_mode='Disabled'"):
        SB3VecEnv(gym.make_vec(POSE, 2))


def test_methods_and_attributes() -> None:
    batch = SB3VecEnv.make(GOAL, 3)
    batch.seed(0)
    seen = batch.reset()
    achieved, desired = seen["achieved_goal"], seen["desired_goal"]
    (rewards,) = batch.env_method("compute_reward", achieved, desired, [{}] * 3, indices=[0])
    assert rewards.tolist() == [-1.0, -1.0, -1.0]
    assert batch.env_method("compute_reward", achieved, achieved, {}, indices=[0])[0].tolist() == [0.0] * 3
    assert batch.get_attr("observation_space", 1) == [gym.make(GOAL).observation_space]
    assert batch.get_attr("render_mode") == [None] * 3
    assert not batch.has_attr("no_such_thing")
    batch.set_attr("note", 5)
    assert batch.get_attr("note", [0, 2]) == [5, 5]
    with pytest.raises(trundle.TrundleError, match="share 'note'"):
        batch.set_attr("note", 5, indices=1)
    with pytest.raises(AttributeError, match="no method 'reset'"):
        batch.env_method("reset")


def test_one_environment_is_restored() -> None:
    batch = SB3VecEnv.make(POSE, 2)
    batch.reset()
    hidden = batch.env_method("hidden_values")
    assert hidden[0].shape == (10,)
    assert not np.array_equal(hidden[0], hidden[1])
    assert np.array_equal(batch.env_method("hidden_values", indices=1)[0], hidden[1])
    (saved,) = batch.env_method("snapshot", indices=1)
    actions = random_actions(2, 1)[0]
    first = batch.step(actions)[0]
    batch.env_method("restore", saved, indices=1)
    again = batch.step(actions)[0]
    assert np.array_equal(again[1], first[1])
    assert not np.array_equal(again[0], first[0])


def test_the_final_info_contains_the_oracle() -> None:
    batch = SB3VecEnv(VectorOracle(gym.make_vec(POSE, 2, autoreset_mode="Disabled", horizon=2)))
    assert batch.env_is_wrapped(VectorOracle) == [True, True]
    assert batch.env_is_wrapped(Monitor, 0) == [False]
    assert batch.get_attr("ACTION_SCALE", 0)[0].tolist() == [100.0, 100.0, 40.0]
    before = batch.reset()
    for actions in random_actions(2, 2):
        observations, _, _, infos = batch.step(actions)
    assert before.shape == (2, 26)
    assert np.array_equal(infos[0]["terminal_observation"][-10:], before[0, -10:])
    assert not np.array_equal(observations[0, -10:], before[0, -10:])


def test_infos_of_wrappers_are_passed_on() -> None:
    batch = SB3VecEnv(RecordEpisodeStatistics(gym.make_vec(POSE, 2, autoreset_mode="Disabled", horizon=3)))
    batch.set_options([{**CENTRE, "goal": [0.0, 0.0, 0.0]}, {}])
    batch.reset()
    infos = [batch.step(np.zeros((2, 3)))[3] for _ in range(3)]
    lengths = [[info.get("episode", {}).get("l") for info in step] for step in infos]
    assert lengths == [[1, None], [None, None], [None, 3]]


class Numbered(VectorWrapper):
    """A batch that counts its episodes."""

    episodes = 0

    def reset(self, **arguments: Any) -> tuple[Any, dict[str, Any]]:
        self.episodes += 1
        return self.env.reset(**arguments)[0], {"episode": np.full(self.num_envs, self.episodes)}


def test_reset_infos_are_kept() -> None:
    batch = SB3VecEnv(Numbered(gym.make_vec(POSE, 2, autoreset_mode="Disabled", horizon=3)))
    batch.set_options([{**CENTRE, "goal": [0.0, 0.0, 0.0]}, {}])
    batch.reset()
    assert batch.reset_infos == [{"episode": 1}, {"episode": 2}]
    batch.step(np.zeros((2, 3)))
    assert batch.reset_infos == [{"episode": 3}, {"episode": 2}]


def test_images_are_tiled() -> None:
    batch = SB3VecEnv.make(POSE, 4, render_mode="rgb_array")
    batch.reset()
    picture = batch.render()
    assert picture is not None
    assert picture.shape == (960, 960, 3)
    assert np.array_equal(picture[480:, :480], batch.get_attr("unwrapped")[0].render()[2])
    assert batch.metadata["render_fps"] == 20
    batch.close()


def test_returns_are_monitored_and_policies_evaluated() -> None:
    batch = VecMonitor(SB3VecEnv.make(POSE, 4, horizon=20))
    policy = PPO("MlpPolicy", batch, policy_kwargs=TINY, device="cpu", seed=0)
    single = Monitor(gym.make(POSE, horizon=20))
    single.reset(seed=0)
    for environments in (batch, single):  # the policy fits both
        rewards, lengths = evaluate_policy(policy, environments, 6, return_episode_rewards=True)
        assert lengths == [20] * 6
        assert max(rewards) < 0


def test_ppo_learns() -> None:
    batch = VecMonitor(SB3VecEnv.make(POSE, 8, horizon=20))
    policy = PPO(
        "MlpPolicy", batch, n_steps=32, batch_size=64, n_epochs=2, policy_kwargs=TINY, device="cpu", seed=0
    )
    before = policy.policy.state_dict()["action_net.bias"].clone()
    policy.learn(2 * 8 * 32)
    assert policy.num_timesteps == 2 * 8 * 32
    assert not torch.equal(before, policy.policy.state_dict()["action_net.bias"])
    assert [episode["l"] for episode in policy.ep_info_buffer] == [20] * 24  # three in each of 64 steps
    assert len(policy.ep_success_buffer) == 24


def test_sac_learns_with_hindsight_replay() -> None:
    options = {"n_sampled_goal": 4, "goal_selection_strategy": "future"}
    policy = SAC(
        "MultiInputPolicy",
        VecNormalize(SB3VecEnv.make(GOAL, 4, horizon=20), norm_reward=False),
        replay_buffer_class=HerReplayBuffer,
        replay_buffer_kwargs=options,
        learning_starts=100,
        batch_size=32,
        buffer_size=2000,
        policy_kwargs=TINY,
        device="cpu",
        seed=0,
    )
    policy.learn(400)
    buffer = policy.replay_buffer
    assert policy._n_updates > 50
    assert np.all(buffer.rewards[: buffer.pos] == -1.0)  # no goal was reached ...
    assert torch.any(buffer.sample(500).rewards == 0.0)  # ... but in hindsight


def test_the_module_is_imported_on_demand() -> None:
    lazily = "import trundle.envs, sys; sys.exit('stable_baselines3' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", lazily]).returncode == 0
    without = "import sys; sys.modules['stable_baselines3'] = None; import trundle.envs.sb3"
    failed = subprocess.run([sys.executable, "-c", without], capture_output=True, text=True)
    assert failed.returncode == 1
    assert "need stable_baselines3: pip install 'trundle[rl]'" in failed.stderr


def test_only_batches_of_trundle_are_accepted() -> None:
    assert isinstance(SB3VecEnv.make(POSE).get_attr("unwrapped")[0], PushVec)
    with pytest.raises(gym.error.Error, match="vector entry point"):
        SB3VecEnv.make("Pendulum-v1")
