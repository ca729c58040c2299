"""Decisions of `trundle.AdaptiveAgent` at a bounded cost: limited rollouts, diagnosis on another thread."""

from __future__ import annotations

import threading
import time
from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np
import pytest

import trundle
from trundle import _native
from trundle.background import Background
from trundle.missing_effects import Extension, Suspicion

WAIT_S = 60.0
"""Longest wait for another thread, s."""
QUICK: dict[str, Any] = {"planner": {"samples": 32, "iterations": 2}}
"""Settings of an agent whose plans do not matter."""


def seen_observations(steps: int) -> tuple[gymnasium.Env[Any, Any], list[Any]]:
    """Return an environment and the observations of an episode with the first agent's actions."""
    env = gymnasium.make("trundle/PushAround-v1", hidden="locked")
    agent = trundle.AdaptiveAgent(env, trundle.AgentSettings(**QUICK))
    observations = [env.reset(seed=3000)[0]]
    for step in range(steps):
        action, _ = agent.predict(observations[-1], episode_start=step == 0)
        observations.append(env.step(action)[0])
    return env, observations


def until_cancelled() -> Iterator[None]:
    """Yield for `WAIT_S`, then fail: the work in the background was not cancelled."""
    given_up = time.monotonic() + WAIT_S
    while time.monotonic() < given_up:
        yield
    raise AssertionError("not cancelled")


@pytest.fixture(scope="module")
def seen() -> tuple[gymnasium.Env[Any, Any], list[Any]]:
    return seen_observations(80)


def test_work_in_the_background_has_a_pool_of_its_own() -> None:
    threads = Background(lambda _: (_native._pool_threads(), threading.get_ident())).result()
    assert threads is not None
    assert threads[0] == 1 and threads[1] != threading.get_ident()

    def failing(_: Any) -> None:
        raise KeyError("x")

    with pytest.raises(KeyError):
        Background(failing).result()


def test_native_work_goes_on_during_work_in_the_background(
    seen: tuple[gymnasium.Env[Any, Any], list[Any]],
) -> None:
    env, observations = seen
    agent = trundle.AdaptiveAgent(env, trundle.AgentSettings(**QUICK))
    for row in observations:
        agent.predict(row)
    recording = agent.beliefs[0].recording(0.05, 0.02)
    begun = threading.Event()

    def work(check: Any) -> None:
        for _ in until_cancelled():
            trundle.fit(recording, starts=1)
            begun.set()
            check()

    busy = Background(work)
    assert begun.wait(WAIT_S)
    agent.predict(observations[0], episode_start=True)
    assert not busy.is_finished
    busy.cancel()
    assert busy.result() is None


class Slow:
    """A search for missing effects that finds friction and ends when it is released."""

    def __init__(self, model: trundle.Model) -> None:
        self.released, self.calls = threading.Event(), list[int]()
        self._model = model

    def __call__(self, given: Suspicion, check: Any) -> Extension:
        self.calls.append(len(given.recording["episode_00"]["t"]))
        if threading.current_thread() is not threading.main_thread():
            assert self.released.wait(WAIT_S)
        return Extension(diagnosed=True, model=self._model, named=("coulomb_friction",))


@pytest.fixture
def slow(monkeypatch: pytest.MonkeyPatch, seen: tuple[gymnasium.Env[Any, Any], list[Any]]) -> Slow:
    env, observations = seen
    agent = trundle.AdaptiveAgent(env, trundle.AgentSettings(**QUICK))
    for row in observations[:40]:
        agent.predict(row)
    text = agent.beliefs[0].model.to_toml()
    friction = '\n[[effect]]\nkind = "coulomb_friction"\nx = 0.1\ny = 0.1\nforce = 5.0\n'
    search = Slow(trundle.Model.from_toml(text + friction))
    monkeypatch.setattr("trundle.learners.find_missing_effects", search)
    return search


def named_at(agent: trundle.AdaptiveAgent) -> list[float]:
    return [update.time for update in agent.beliefs[0].updates if update.named]


def test_a_diagnosis_is_used_after_its_delay(
    seen: tuple[gymnasium.Env[Any, Any], list[Any]], slow: Slow
) -> None:
    env, observations = seen
    slow.released.set()

    def actions(delay: float, pause: float = 0.0) -> tuple[list[Any], list[float]]:
        settings = trundle.AgentSettings(diagnose=True, diagnosis_delay=delay, **QUICK)
        agent, chosen = trundle.AdaptiveAgent(env, settings), []
        for row in observations:
            chosen.append(agent.predict(row)[0].tolist())
            time.sleep(pause)
        return chosen, named_at(agent)

    at_once, times = actions(0.0)
    assert times == [3.0]
    delayed, times = actions(0.35)
    assert times == pytest.approx([3.35])
    assert delayed[:60] == at_once[:60] and delayed != at_once
    # The speed of the computer does not matter.
    assert actions(0.35, pause=0.003) == (delayed, times)


def test_in_real_time_the_agent_never_waits_for_a_diagnosis(
    seen: tuple[gymnasium.Env[Any, Any], list[Any]], slow: Slow
) -> None:
    env, observations = seen
    agent = trundle.AdaptiveAgent(env, trundle.AgentSettings(diagnose=True, realtime=True, **QUICK))
    for row in observations[:70]:
        agent.predict(row)
    (belief,) = agent.beliefs
    assert slow.calls and belief.diagnosis is not None and named_at(agent) == []
    slow.released.set()
    belief.diagnosis.work.result()
    agent.predict(observations[70])
    assert named_at(agent) == pytest.approx([3.5])
    assert belief.diagnosis is None and belief.diagnosed_at == pytest.approx(3.0)


def test_a_new_episode_cancels_the_diagnosis(
    seen: tuple[gymnasium.Env[Any, Any], list[Any]], monkeypatch: pytest.MonkeyPatch
) -> None:
    env, observations = seen
    begun = threading.Event()

    def endless(given: Suspicion, check: Any) -> Extension:
        begun.set()
        for _ in until_cancelled():
            check()
            time.sleep(0.001)
        raise AssertionError("unreachable")

    monkeypatch.setattr("trundle.learners.find_missing_effects", endless)
    agent = trundle.AdaptiveAgent(env, trundle.AgentSettings(diagnose=True, realtime=True, **QUICK))
    for row in observations[:62]:
        agent.predict(row)
    pending = agent.beliefs[0].diagnosis
    assert pending is not None and begun.wait(WAIT_S) and not pending.work.is_finished
    agent.predict(observations[0], episode_start=True)
    assert pending.work.result() is None
    assert agent.beliefs[0].diagnosis is None


def test_an_invalid_delay_is_refused() -> None:
    for delay in (-1.0, np.inf):
        with pytest.raises(trundle.TrundleError, match="diagnosis_delay"):
            trundle.AgentSettings(diagnose=True, diagnosis_delay=delay)
