"""Learning of `trundle.AdaptiveAgent`: physical laws, regressions, diagnosis, and dual control."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import gymnasium
import numpy as np
import pytest
import tomli_w

import trundle
from trundle import _native
from trundle._native import Laws
from trundle.agent import Belief
from trundle.belief import about_origin
from trundle.envs import Observation
from trundle.experiments.comparison.config import read
from trundle.experiments.comparison.world import make_world
from trundle.missing_effects import Extension, Suspicion, fit_present_model, supposed_extension

FRICTION = {"kind": "coulomb_friction", "x": 0.2, "y": 0.1, "force": 55.0}
AROUND = "trundle/PushAround-v0"
COMPARE = Path(__file__).resolve().parents[2] / "configs/experiments/compare.toml"


def played(
    steps: int, env_id: str = AROUND, seed: int = 3000, **arguments: Any
) -> tuple[Belief, dict[str, Any]]:
    """Return the belief of an agent after at most `steps` steps, and the last info."""
    options = arguments.pop("options", {"hidden": "locked"})
    env = gymnasium.make(env_id, **options)
    observation, info = env.reset(seed=seed)
    agent = trundle.AdaptiveAgent(env, trundle.AgentSettings(**arguments))
    for step in range(steps):
        action, _ = agent.predict(observation, episode_start=step == 0)
        observation, _, terminated, truncated, info = env.step(action)
        if terminated or truncated:
            break
    return agent.beliefs[0], info


def test_a_diagnosed_effect_joins_the_model() -> None:
    belief, info = played(200, diagnose=True, options={"hidden": "locked", "effects": [FRICTION]})
    assert info["is_success"]
    named = [update for update in belief.updates if update.named]
    assert [update.named for update in named] == [("coulomb_friction",)]
    assert named[0].time < 5.0
    found = {one["name"]: one["mean"] for one in belief.updates[-1].estimate}
    assert found["coulomb_friction.force"] == pytest.approx(55.0, rel=0.05)
    assert found["body.mass"] == pytest.approx(22.0, rel=0.05)


def test_a_sufficient_model_starts_no_diagnosis() -> None:
    belief, info = played(200, diagnose=True)
    assert info["is_success"]
    assert belief.diagnosed_at == 0.0
    assert not any(update.named for update in belief.updates)


@pytest.mark.slow
def test_an_unnamed_effect_is_used_if_it_predicts_better(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # A fake diagnosis returns friction as a candidate without naming it.
    def unsure(*args: Any, **options: Any) -> SimpleNamespace:
        outcome = diagnose(*args, **options)
        answer: dict[str, Any] = {**outcome.answer}
        names = [one["effect"] for one in answer["missing"]]
        if names:
            answer |= {
                "verdict": "unexplained",
                "missing": [],
                "alternatives": [{"effect": " + ".join(names)}],
            }
        return SimpleNamespace(answer=answer, model=outcome.model)

    diagnose = _native._diagnose
    monkeypatch.setattr(_native, "_diagnose", unsure)
    settings = read(COMPARE)
    env, observation = make_world(settings.worlds["friction"], 3032, {})
    agent = trundle.AdaptiveAgent(env, trundle.AgentSettings(diagnose=True))
    for step in range(84):
        action, _ = agent.predict(observation, episode_start=step == 0)
        observation = env.step(action)[0]
    (belief,) = agent.beliefs
    assert not any(update.named for update in belief.updates)
    (update,) = (update for update in belief.updates if update.supposed)
    # The fit continues, so that the values change.
    assert belief.updates[-1].time > update.time
    kinds = [{one["name"] for one in each.model.parameters} for each in (update, belief.updates[-1])]
    assert kinds[0] == kinds[1] and belief.updates[-1].model.to_toml() != update.model.to_toml()


def test_an_unnamed_effect_is_not_used_if_it_predicts_no_better() -> None:
    belief, _ = played(60)
    given = Suspicion(belief.recording(0.05, 0.02), None, belief.model, None, starts=1, seed=0)
    found = fit_present_model(given)
    for candidates in ([{"effect": "coulomb_friction"}], []):
        assert supposed_extension(given, candidates, found, lambda: None) == Extension(diagnosed=True)


@pytest.mark.parametrize(
    ("law", "effect"),
    [
        ({"kind": "spin_drag", "spin": 40.0}, "second_wheel"),
        ({"kind": "support_friction", "force": 40.0, "spread": 1.0}, "coulomb_friction"),
    ],
)
def test_the_best_law_is_used_for_an_unnamed_effect(law: dict[str, Any], effect: str) -> None:
    belief, _ = played(64, options={"hidden": "locked", "effects": [law]})
    given = Suspicion(belief.recording(0.05, 0.02), None, belief.model, None, starts=2, seed=0)
    richer = supposed_extension(given, [{"effect": effect}], fit_present_model(given), lambda: None)
    assert richer.model is not None
    assert (richer.named, richer.supposed) == ((), (effect,))
    assert law["kind"] in {one["name"].split(".")[0] for one in richer.model.parameters}


@pytest.mark.parametrize("learner", ["shooting", "linear"])
def test_other_learners_reach_the_goal(learner: str) -> None:
    belief, info = played(300, "trundle/LockedWheel-v0", learner=learner, seed=1)
    assert info["is_success"]
    assert belief.fits > 0
    assert (belief.regression is not None) == (learner == "linear")


def test_planning_uses_a_locally_weighted_regression() -> None:
    belief, _ = played(
        24, "trundle/LockedWheel-v0", learner="local", planner={"samples": 32, "iterations": 2}
    )
    assert isinstance(belief.regression, _native._Regression)
    assert belief.regression.widths is not None


def test_it_plans_on_several_models_only_while_they_differ() -> None:
    belief, _ = played(60, learner="filter")
    values = [update.value_of_information for update in belief.updates]
    assert values[0] > 0.02 > values[-1]
    assert belief.models == (belief.model,)
    early, _ = played(5, learner="filter")
    assert len(early.models) == 5


def test_a_probing_agent_starts_with_five_models_and_converges() -> None:
    belief, _ = played(1, probe=True, learner="filter")
    assert len(belief.models) == 5
    belief, info = played(300, probe=True, learner="filter")
    assert info["is_success"]
    assert len(belief.models) == 1


def test_learning_stops_after_a_number_of_pushes() -> None:
    belief, info = played(300, pushes=2)
    assert info["is_success"]
    assert belief.updates[-1].time == 1.0


def test_it_regrasps_if_the_grasp_is_insufficient() -> None:
    bed = {"hidden": "locked", "object": "bed"}
    kept, _ = played(300, "trundle/PushPose-v0", seed=3, options=bed)
    belief, info = played(300, "trundle/PushPose-v0", seed=3, options={**bed, "action": "regrasp"})
    assert info["is_success"]
    places = [update.regrasp for update in belief.updates if update.regrasp]
    assert places
    assert belief.latest.grasp == pytest.approx(places[-1])
    assert len(belief.observations) < 0.75 * len(kept.observations)


def test_an_open_gripper_does_not_push() -> None:
    # For an object that rolls freely, every impulse changes the velocity.
    env = gymnasium.make("trundle/PushPose-v0", hidden="none", action="regrasp", noise=0.0)
    observation, _ = env.reset(seed=1)
    source: Any = env.unwrapped
    truth = trundle.Model.from_toml(tomli_w.dumps(source.hidden_model()))
    belief = trundle.AdaptiveAgent(env, model=truth)._first_belief(Observation(observation))
    push, leave = np.array([0.3, 0.1, 0, 0, 0, -1.0]), np.array([0, 0, 0, 0.5, 0.5, 1.0])
    for action in [push] * 4 + [leave] * 25 + [push] * 2:
        belief.observations.append(Observation(env.step(action.astype(np.float32))[0]))
    assert np.any(belief.latest.grasp != belief.observations[0].grasp)
    before, wrench, dt, after = belief.transitions(0.05, 0.02)
    mass = source.hidden_model()["body"]["mass"]

    def gained(impulse: Any) -> Any:
        middle = np.array([turned(one, angle) for one, angle in zip(impulse, before[:, 2], strict=True)])
        return middle / mass

    speeds = after[:, 3:5] - before[:, 3:5]
    assert gained(wrench[:, :2] * dt[:, None]) == pytest.approx(speeds, abs=2e-3)
    columns = belief.columns(0.05, 0.02)
    force = np.stack([columns["force_x"], columns["force_y"]], axis=1)
    within = np.digitize(columns["t"][:-1] + 1e-9, 0.05 * np.arange(len(belief.observations))) - 1
    parts = (force[1:] + force[:-1]) / 2 * np.diff(columns["t"])[:, None]
    summed = np.array([parts[within == step].sum(axis=0) for step in range(len(dt))])
    assert gained(summed) == pytest.approx(speeds, abs=2e-3)


def test_it_keeps_learning_along_a_path() -> None:
    belief, _ = played(60, "trundle/PushPath-v0")
    assert belief.updates[-1].time == 2.95
    assert belief.model.to_toml() != belief.updates[0].model.to_toml()


def test_the_observation_contains_the_size_of_random_objects() -> None:
    belief, info = played(300, options={"hidden": "locked", "object": ["chair", "bookcase"]}, seed=5)
    assert info["is_success"]
    corner = np.max(belief.metadata["object"]["footprint"], axis=0)
    assert corner == pytest.approx(belief.latest.half_size)


def test_the_oracle_tracks_the_angle_of_a_caster() -> None:
    caster = {"kind": "caster_swivel", "x": 0.5, "y": -0.3, "trail": 0.05, "mu_side": 150.0}
    env = gymnasium.make(AROUND, hidden="none", effects=[caster])
    observation, _ = env.reset(seed=2)
    source: Any = env.unwrapped
    model = trundle.Model.from_toml(tomli_w.dumps(source.hidden_model()))
    agent = trundle.AdaptiveAgent(env, trundle.AgentSettings(adapt=False), model=model)
    for step in range(40):
        action, (belief,) = agent.predict(observation, episode_start=step == 0)
        observation = env.step(action)[0]
    (angle,) = belief.inner_states(0.05)
    assert Laws(model).starts != [angle]
    # The wheel trails behind the motion of its pivot, in the object frame.
    before, now = belief.observations[-6], belief.observations[-1]
    pivot = [seen.position + turned(np.array([0.5, -0.3]), seen.heading) for seen in (before, now)]
    way = np.arctan2(*(pivot[1] - pivot[0])[::-1]) - now.heading
    assert abs(np.angle(np.exp(1j * (angle - way)))) < 0.5 or (
        abs(np.angle(np.exp(1j * (angle - way + np.pi)))) < 0.5
    )


def turned(point: Any, angle: float) -> Any:
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([cos * point[0] - sin * point[1], sin * point[0] + cos * point[1]])


def test_a_wrench_is_transported_to_the_origin() -> None:
    # 10 N along y, half a metre in front of the origin.
    assert about_origin(np.array([0.0, 10.0, 1.0]), np.array([0.5, 0.2])).tolist() == [0.0, 10.0, 6.0]
    assert about_origin(np.array([10.0, 0.0, 0.0]), np.array([0.5, 0.2])).tolist() == [10.0, 0.0, -2.0]


@pytest.mark.parametrize(
    ("arguments", "reason"),
    [
        ({"learner": "neural"}, "learner = 'neural': choose one of body, filter, shooting, linear, local"),
        ({"learner": "linear", "diagnose": True}, "a regression cannot be diagnosed"),
        ({"adapt": False, "probe": True, "learner": "filter"}, "these need adapt = True"),
        ({"probe": True}, "learner = 'body': it has one most probable model"),
        ({"planner": {"curiosity": -1.0}}, "curiosity"),
        ({"pushes": 0}, "pushes = 0"),
    ],
)
def test_invalid_arguments_are_refused(arguments: dict[str, Any], reason: str) -> None:
    env = gymnasium.make("trundle/LockedWheel-v0")
    with pytest.raises(trundle.TrundleError, match=reason):
        trundle.AdaptiveAgent(env, trundle.AgentSettings(**arguments))
