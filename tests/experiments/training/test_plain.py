"""The state of a training as plain data; `tests/rl` tests tensors and complete trainings."""

from __future__ import annotations

import pickle
import random
from collections import deque
from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest

from trundle import TrundleError
from trundle.experiments.training import state_file


def kept(path: Path, state: Any) -> Any:
    state_file.save(path, state)
    return state_file.load(path)


def test_a_state_is_restored_bit_for_bit(tmp_path: Path) -> None:
    state = {
        "networks": {"optimizer": {"state": {0: {"step": np.float32(3)}}, "param_groups": [{"lr": 1e-4}]}},
        "buffer": deque([{"r": np.float32(0.1), "l": 3, "t": 0.1 + 0.2}], maxlen=100),
        "random": (random.getstate(), np.random.default_rng(0).bit_generator.state, np.random.get_state()),
        "none": None,
        "flags": np.array([True, False]),
        "nothing": np.zeros((0, 3), np.float16),
        "strange": [float("inf"), -0.0, 2**80, "ü\n", True, ()],
    }
    again = kept(tmp_path / "state.pickle", state)
    # Arrays are not compared by ==, but their pickles are equal.
    assert pickle.dumps(again) == pickle.dumps(kept(tmp_path / "twice.pickle", again))
    np.testing.assert_equal(again, state)
    assert type(again["buffer"]) is deque
    assert again["buffer"].maxlen == 100
    assert type(again["buffer"][0]["r"]) is np.float32
    assert type(again["random"][0]) is tuple
    assert again["networks"]["optimizer"]["state"].keys() == {0}
    assert again["flags"].dtype == bool
    assert again["nothing"].dtype == np.float16
    random.setstate(again["random"][0])
    np.random.set_state(again["random"][2])


def test_an_episode_continues_from_a_snapshot(tmp_path: Path) -> None:
    env: Any = gym.make("trundle:trundle/LockedWheel-v0").unwrapped
    env.reset(seed=1)
    env.step(np.array([0.5, 0.1, 0.0]))
    again = kept(tmp_path / "state.pickle", {"episodes": [env.snapshot()]})["episodes"][0]
    ahead = env.step(np.array([0.2, 0.0, 0.3]))
    env.restore(again)
    np.testing.assert_array_equal(env.step(np.array([0.2, 0.0, 0.3]))[0], ahead[0])


class Trap:
    def __reduce__(self) -> Any:
        return (Path.touch, (Path("trapped"),))


def test_reading_executes_no_code(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    state_file.save(tmp_path / "trap.pickle", {"a": Trap()})
    np.savez(tmp_path / "arrays.pickle", a=np.zeros(3))
    (tmp_path / "empty.pickle").touch()
    (tmp_path / "text.pickle").write_text("a state")
    for name in ("trap", "arrays", "empty", "text"):
        with pytest.raises(TrundleError, match="not a checkpoint"):
            state_file.load(next(tmp_path.glob(f"{name}.pickle*")))
    assert not (tmp_path / "trapped").exists()
