"""Valid but excessive values are refused before memory, time or number range are exhausted."""

from __future__ import annotations

import pickle
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

import trundle
from trundle._native import NotFiniteError, Snapshot
from trundle.envs import ActionError

OBJECT = Path(__file__).parents[2] / "configs" / "objects" / "office_table.toml"
PUSHING = {"kind": "directional_friction", "angle": 0.3, "difference": -1e6}
"""A valid effect with negative friction, under which the motion diverges."""
NAMED = r"directional_friction\.difference = -?1000000 N·s/m"


@pytest.mark.parametrize("action", ["push", "wrench", "velocity"])
@pytest.mark.parametrize("count", [None, 1, 20])
def test_a_motion_that_is_not_finite_names_the_parameter(action: str, count: int | None) -> None:
    options: dict[str, Any] = {"action": action, "effects": [PUSHING]}
    env: Any
    if count is None:
        env = gym.make("trundle:trundle/PushPose-v0", **options)
    else:
        env = gym.make_vec("trundle:trundle/PushPose-v0", num_envs=count, **options)
    env.reset(seed=0)
    env.action_space.seed(0)

    def play() -> None:
        for _ in range(40):
            observation, reward, *_ = env.step(env.action_space.sample())
            assert np.isfinite(observation).all()
            assert np.isfinite(reward).all()
            if count is None:
                env.reset()

    with pytest.raises(NotFiniteError, match=NAMED) as refused:
        play()
    assert isinstance(refused.value, trundle.TrundleError)
    assert not isinstance(refused.value, ActionError)


def test_a_rollout_that_is_not_finite_names_the_parameter() -> None:
    text = (
        'format = "trundle-model/1"\n[body]\nmass = 20.0\nfootprint = [[0, 0], [1, 0], [1, 1]]\n[[effect]]\n'
        'kind = "directional_friction"\nangle = 0.0\ndifference = '
    )
    model = trundle.Model.from_toml(f"{text}-1e6")
    wrench = np.tile([10.0, 0.0, 0.0], (50, 1))
    with pytest.raises(NotFiniteError, match=NAMED):
        model.rollout([0.0] * 3, [0.1, 0.0, 0.0], np.linspace(0, 5, 50), wrench)
    poses, _ = trundle.Model.from_toml(f"{text}1.0").rollout(
        [0.0] * 3, [0.1, 0.0, 0.0], np.linspace(0, 5, 50), wrench
    )
    assert np.isfinite(poses).all()


def scenario(folder: Path, more: str) -> Path:
    path = folder / "scenario.toml"
    path.write_text(f'format = "trundle-scenario/1"\nname = "x"\nobject = "{OBJECT}"\n{more}')
    return path


PUSH = '[[push]]\ngrasp = [-0.3, 0.0, 0.0]\ndrive = "velocity"\nknots = [[0, 0, 0, 0], [{end}, 0.05, 0, 0]]\n'


def test_a_simulation_that_is_not_finite_names_the_parameter(tmp_path: Path) -> None:
    effect = '[[effect]]\nkind = "directional_friction"\nangle = 0.3\ndifference = -1e6\n'
    with pytest.raises(trundle.TrundleError, match=NAMED):
        trundle.simulate(scenario(tmp_path, effect + PUSH.format(end=3)))


@pytest.mark.parametrize(
    ("more", "words"),
    [
        (PUSH.format(end=8e7), r"80000000 s in total, which is 3\.2e11 steps; the limit is 100000000"),
        (PUSH.format(end=1e300), "steps; the limit is 100000000: shorten the pushes"),
        ("step = 1e-9\n" + PUSH.format(end=800), "lengthen `step`"),
        (PUSH.format(end=24_000), "samples; the limit is 4000000: .*lower `sensor.rate`"),
        ("[random]\ncount = 10000\nduration = 3600.0", r"1\.4e11 steps; the limit"),
    ],
)
def test_an_endless_scenario_is_refused(tmp_path: Path, more: str, words: str) -> None:
    with pytest.raises(trundle.TrundleError, match=f"(?s)scenario.toml: the pushes take .*{words}"):
        trundle.simulate(scenario(tmp_path, more))


@pytest.mark.parametrize("count", [10**7, 2**64, 2**80])
def test_too_many_environments_are_refused(count: int) -> None:
    with pytest.raises(trundle.TrundleError, match=r"an environment takes up to 64 KiB and \d+ MiB are free"):
        gym.make_vec("trundle:trundle/PushPose-v0", num_envs=count)


def test_a_snapshot_with_a_flipped_bit_is_refused() -> None:
    env: Any = gym.make("trundle:trundle/PushAround-v0").unwrapped
    env.reset(seed=1)
    env.step(env.action_space.sample())
    snapshot = env.snapshot()
    options, state = snapshot.__getnewargs__()
    assert pickle.loads(pickle.dumps(snapshot)).__getnewargs__() == (options, state)
    for bit in range(0, 8 * len(state), 5):
        flipped = bytearray(state)
        flipped[bit // 8] ^= 1 << (bit % 8)
        with pytest.raises(trundle.TrundleError, match="not a saved state of this task: it is damaged"):
            Snapshot(options, bytes(flipped))


def test_a_snapshot_of_an_earlier_version_is_read() -> None:
    """Earlier snapshots had no checksum."""
    env: Any = gym.make("trundle:trundle/PushAround-v0").unwrapped
    env.reset(seed=1)
    options, state = env.snapshot().__getnewargs__()
    assert Snapshot(options, state[16:]).__getnewargs__() == (options, state)
