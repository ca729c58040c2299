"""Dynamics models in NumPy, and the adaptive agent that plans on them; `tests/rl` tests their training."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import gymnasium as gym
import numpy as np
import pytest
from numpy.typing import NDArray

from trundle import TrundleError
from trundle.envs import Observation
from trundle.experiments.comparison.config import Agent, Worlds
from trundle.experiments.comparison.episode import play
from trundle.experiments.training.dynamics.collect import Episodes, collect
from trundle.experiments.training.dynamics.errors import prediction_errors
from trundle.experiments.training.dynamics.learner import dynamics_agent
from trundle.experiments.training.dynamics.model import About, DynamicsModel, Scales, load
from trundle.experiments.training.dynamics.motion import INPUTS, SHAPE, Motion, motion_of, shape_of
from trundle.experiments.training.network import Memory, Network

TASK = "trundle/PushPose-v1"
FREE: dict[str, Any] = {"object": "random", "hidden": "none", "mass": (20.0, 20.0)}
PERIOD = 0.05
ABOUT = About("free", "0", 1, 0, 0, TASK, {}, PERIOD)
UNIT = Scales(np.zeros(16, np.float32), np.ones(16, np.float32), np.ones(3, np.float32))


def layer(rows: NDArray[np.float64], entries: int = INPUTS + SHAPE) -> tuple[Any, Any]:
    """Return a linear layer of the first inputs."""
    weight = np.zeros((len(rows), entries), np.float32)
    weight[:, : rows.shape[1]] = rows
    return weight, np.zeros(len(rows), np.float32)


def free_body(mass: float = 20.0, inertia: float = 3.0) -> DynamicsModel:
    """Return the exact model, but for turning axes, of a body that rolls freely about its mass centre."""
    gains = PERIOD / np.array([mass, mass, inertia])
    rows = np.zeros((6, INPUTS))
    rows[:3, 3:6], rows[:3, 6:9] = 0.2 * np.diag(gains), 0.8 * np.diag(gains)
    return DynamicsModel(ABOUT, UNIT, [Network([layer(rows)], "relu")])


def remembering(units: int = 5, seed: int = 0) -> DynamicsModel:
    """Return two random networks with memories."""
    random = np.random.default_rng(seed)

    def values(*shape: int) -> Any:
        return random.normal(0.0, 0.3, shape).astype(np.float32)

    networks = []
    for _ in range(2):
        memory = Memory(values(4 * units, INPUTS + SHAPE + 3), values(4 * units, units), values(4 * units))
        layers = [(values(8, INPUTS + SHAPE + units), values(8)), (values(6, 8), values(6))]
        networks.append(Network(layers, "relu", memory))
    return DynamicsModel(ABOUT, UNIT, networks)


def rollout(model: DynamicsModel, twist: list[float], wrenches: Any, heading: float = 0.0) -> Any:
    start = np.array([[0.0, 0.0, heading]]), np.array([twist])
    return model.rollout(model.start(1), np.zeros((1, SHAPE)), start, np.asarray(wrenches))


def test_steps_reproduce_the_observed_motion() -> None:
    env: Any = gym.make_vec(TASK, 3, "vector_entry_point", object="random")
    rows = [env.reset(seed=0)[0]]
    for _ in range(5):
        rows.append(env.step(np.full((3, 3), 0.4, np.float32))[0])
    seen, motion = Observation(np.stack(rows)), motion_of(np.stack(rows))
    assert motion.inputs.shape == (5, 3, INPUTS)
    cos, sin = np.cos(seen.heading[:-1]), np.sin(seen.heading[:-1])

    def world(vectors: Any) -> Any:
        return np.stack(
            [cos * vectors[..., 0] - sin * vectors[..., 1], sin * vectors[..., 0] + cos * vectors[..., 1]], -1
        )

    assert np.allclose(seen.position[:-1] + world(motion.targets[..., 3:]), seen.position[1:])
    after = motion.inputs[..., :3] + motion.targets[..., :3]
    assert np.allclose(world(after), seen.velocity[1:])
    assert np.allclose(after[..., 2], seen.spin[1:])
    lever = seen.grasp[..., 0] * seen.force[..., 1] - seen.grasp[..., 1] * seen.force[..., 0]
    assert np.allclose(motion.inputs[..., 5], (seen.torque + lever)[:-1])


def test_a_body_without_forces_keeps_its_velocity_while_it_turns() -> None:
    states = rollout(free_body(), [0.4, 0.1, 1.0], np.zeros((1, 11, 3)))
    assert states[0, 0, -1] == pytest.approx([0.2, 0.05, 0.5, 0.4, 0.1, 1.0], abs=1e-6)


def test_forces_act_in_axes_of_the_object() -> None:
    wrenches = np.tile([20.0, 0.0, 0.0], (1, 11, 1))
    states = rollout(free_body(), [0.0, 0.0, 0.0], wrenches, heading=np.pi / 2)
    assert states[0, 0, -1] == pytest.approx([0.0, 0.125, np.pi / 2, 0.0, 0.5, 0.0], abs=1e-6)


def test_contexts_of_several_objects_are_separate() -> None:
    model, random = remembering(), np.random.default_rng(1)
    shape, wrenches = random.normal(size=(3, SHAPE)), random.normal(size=(3, 5, 3))
    motions = [Motion(random.normal(size=(3, INPUTS)), random.normal(size=(3, 6))) for _ in range(4)]
    context = model.start(3)
    for motion in motions:
        context = model.remember(context, motion, shape)
    start = np.zeros((3, 3)), random.normal(size=(3, 3))
    together = model.rollout(context, shape, start, wrenches)
    assert together.shape == (2, 3, 4, 6)
    for k in range(3):
        own = model.start(1)
        for motion in motions:
            own = model.remember(
                own, Motion(motion.inputs[k : k + 1], motion.targets[k : k + 1]), shape[k : k + 1]
            )
        one = (start[0][k : k + 1], start[1][k : k + 1])
        alone = model.rollout(own, shape[k : k + 1], one, wrenches[k : k + 1])
        assert np.allclose(alone[:, 0], together[:, k], atol=1e-5)
    unaware = model.rollout(model.start(3), shape, start, wrenches)
    assert np.abs(unaware - together).max() > 1e-3


def test_a_file_holds_the_model(tmp_path: Path) -> None:
    model, file = remembering(), tmp_path / "model.npz"
    model.save(file)
    again = load(file)
    assert again.about == model.about
    wrenches = np.ones((1, 5, 3))
    assert np.array_equal(rollout(again, [0.1] * 3, wrenches), rollout(model, [0.1] * 3, wrenches))
    content = file.read_bytes()
    again.save(file)
    assert file.read_bytes() == content
    np.savez(tmp_path / "other.npz", a=np.zeros(3))
    with pytest.raises(TrundleError, match="not a dynamics model"):
        load(tmp_path / "other.npz")


def test_the_agent_reaches_the_goal_on_a_true_model() -> None:
    env = gym.make(TASK, **FREE)
    observation, info = env.reset(seed=4)
    agent = dynamics_agent(env, free_body())
    over = False
    while not over:
        action, (belief,) = agent.predict(observation, episode_start=not info)
        observation, _, terminated, truncated, info = env.step(action)
        over = terminated or truncated
    assert info["is_success"]
    assert belief.fits > 10


def test_the_agent_remembers_the_motion_of_the_episode() -> None:
    env = gym.make(TASK, **FREE)
    observation, _ = env.reset(seed=0)
    model = remembering()
    agent = dynamics_agent(env, model)
    rows = [observation]
    for step in range(4):
        action, (belief,) = agent.predict(observation, episode_start=step == 0)
        observation, *_ = env.step(action)
        rows.append(observation)
    agent.predict(observation, episode_start=False)
    motion, context = motion_of(np.stack(rows)[:, None]), model.start(1)
    for inputs, targets in zip(*motion, strict=True):
        context = model.remember(context, Motion(inputs, targets), shape_of(rows[0][None]))
    prediction: Any = belief.regression
    found, expected = np.array(prediction._context), np.array(context)
    assert np.allclose(found, expected)
    assert np.abs(expected).max() > 0.0


@pytest.mark.parametrize(
    ("env_id", "options", "message"),
    [
        ("trundle/PushPose-v0", {"object": "random"}, "version 1"),
        (TASK, {}, "version 1"),
        (TASK, {"object": "random", "substeps": 50}, r"an action lasts 0.1 s.*0.05 s"),
    ],
)
def test_unsuitable_environments_are_refused(env_id: str, options: dict[str, Any], message: str) -> None:
    with pytest.raises(TrundleError, match=message):
        dynamics_agent(gym.make(env_id, **options), free_body())


def test_a_plan_of_other_steps_is_refused() -> None:
    from trundle import AgentSettings

    env = gym.make(TASK, **FREE)
    agent = dynamics_agent(env, free_body(), AgentSettings(arm=False, planner={"hold": 0.12}))
    with pytest.raises(TrundleError, match=r"hold = 0.12: must be a multiple"):
        agent.predict(env.reset(seed=0)[0], episode_start=True)


def test_episodes_are_pushed_at_random_or_towards_the_goal() -> None:
    episodes = collect(TASK, FREE, 7, 40, 60, 0.5)
    again = collect(TASK, FREE, 7, 40, 60, 0.5)
    assert np.array_equal(episodes.observations, again.observations)
    seen = Observation(episodes.observations)
    away = np.hypot(*np.moveaxis(seen.goal_position - seen.position, -1, 0))
    nearer = (np.minimum.accumulate(away)[-1] / away[0]) < 0.7
    assert nearer[:20].mean() < 0.5
    assert nearer[20:].mean() > 0.9
    # Nothing after the end of an episode is valid.
    ends = np.diff(episodes.valid.astype(int), axis=0)
    assert (ends <= 0).all()


def test_errors_are_small_for_a_true_model_and_large_for_a_wrong_one() -> None:
    # A square plate of 20 kg without effects would be exact; random outlines have other moments of inertia.
    episodes = collect(TASK, FREE, 7, 60, 30, 0.5)
    true, wrong = (prediction_errors(free_body(mass), episodes, 0.25) for mass in (20.0, 60.0))
    assert true["episodes"] > 30
    assert true["speed"] < 0.6 * wrong["speed"]
    assert true["distance"] < 0.6 * wrong["distance"]
    late = Episodes(episodes.observations, np.zeros_like(episodes.valid))
    late.valid[:, :5] = True
    assert prediction_errors(free_body(), late, 0.25)["episodes"] == 5


def test_a_comparison_plays_a_dynamics_model(tmp_path: Path) -> None:
    file = tmp_path / "model.npz"
    remembering().save(file)
    worlds = Worlds("", TASK, 3, 1, [], {**FREE, "horizon": 8})
    agent = Agent("", "dynamics", files=[str(file)])
    (row, timing), (again, _) = (play(worlds, agent, 0, 3) for _ in range(2))
    assert row == again
    assert timing["decisions"] == 8
    assert row["fits"] == 7
    assert not agent.learns
