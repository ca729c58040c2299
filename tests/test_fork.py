"""A forked child works, although the threads of its parent do not exist in it."""

from __future__ import annotations

import multiprocessing
import os
import signal
import time
from collections.abc import Callable
from pathlib import Path

import gymnasium as gym
import pytest

import trundle
from trundle.envs.vector import PushVec

pytestmark = [
    pytest.mark.skipif(not hasattr(os, "fork"), reason="the system has no fork"),
    pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning"),
]

OBJECT = Path(__file__).parents[1] / "configs" / "objects" / "office_table.toml"
SCENARIO = f"""
format = "trundle-scenario/1"
name = "two short pushes"
object = "{OBJECT}"
[random]
count = 2
duration = 1.5
"""
PATIENCE = 120.0
"""Timeout of a child, s."""
WALL = [[[1.0, -0.1], [1.1, -0.1], [1.1, 0.1], [1.0, 0.1]]]


class Work:
    """Work on all cores. Afterwards this process has threads that a fork does not have."""

    def __init__(self, folder: Path) -> None:
        scenario = folder / "scenario.toml"
        scenario.write_text(SCENARIO)
        self.recording = trundle.simulate(scenario)
        self.envs = gym.make_vec(
            "trundle:trundle/LockedWheel-v0", num_envs=32, vectorization_mode="vector_entry_point"
        )
        assert isinstance(self.envs, PushVec)
        self.envs.reset(seed=0)
        self.planner = trundle.Planner([-50.0, -50.0, -20.0], [50.0, 50.0, 20.0], samples=64, horizon=10)

    def check(self) -> None:
        trundle.check(self.recording)

    def fit(self) -> None:
        self.fitted = trundle.fit(self.recording, starts=1)

    def step(self) -> None:
        self.envs.step(self.envs.action_space.sample())

    def plan(self) -> None:
        self.planner.restart()
        self.planner.plan(self.fitted.model, [0.0] * 3, [0.0] * 3, [2.0, 0.0, 0.0], [-0.3, 0.0], WALL)

    def all(self) -> None:
        for one in (self.check, self.fit, self.step, self.plan):
            one()


@pytest.fixture(scope="module")
def work(tmp_path_factory: pytest.TempPathFactory) -> Work:
    work = Work(tmp_path_factory.mktemp("fork"))
    work.all()
    return work


def in_a_fork(task: Callable[[], None]) -> int:
    """Return the child's exit status; -1 if it hung."""
    child = os.fork()
    if child == 0:
        status = 1
        try:
            task()
            status = 0
        finally:
            os._exit(status)
    end = time.monotonic() + PATIENCE
    while time.monotonic() < end:
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.02)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return -1


@pytest.mark.parametrize("name", ["check", "fit", "step", "plan"])
def test_a_forked_child_does_not_wait_for_threads_of_its_parent(work: Work, name: str) -> None:
    assert in_a_fork(getattr(work, name)) == 0


def test_nested_forks_work(work: Work) -> None:
    def in_turn() -> None:
        work.check()
        assert in_a_fork(work.check) == 0

    assert in_a_fork(in_turn) == 0
    work.check()


def test_multiprocessing_works(work: Work) -> None:
    child = multiprocessing.get_context("fork").Process(target=work.all)
    child.start()
    child.join(2 * PATIENCE)
    hung = child.is_alive()
    child.kill()
    assert not hung
    assert child.exitcode == 0
