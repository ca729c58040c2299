"""How `trundle.AdaptiveAgent` learns: by laws, by regression, with the diagnoser, and by pushes that tell."""

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
from trundle.learners import Physics

FRICTION = {"kind": "coulomb_friction", "x": 0.2, "y": 0.1, "force": 55.0}
AROUND = "trundle/PushAround-v0"
COMPARE = Path(__file__).resolve().parents[2] / "configs/experiments/compare.toml"


def played(steps: int, env_id: str = AROUND, seed: int = 3000, **told: Any) -> tuple[Belief, dict[str, Any]]:
    """Return what an agent believes after so many steps at the most, and how the last one went."""
    options = told.pop("options", {"hidden": "locked"})
    env = gymnasium.make(env_id, **options)
    observation, info = env.reset(seed=seed)
    agent = trundle.AdaptiveAgent(env, **told)
    for step in range(steps):
        action, _ = agent.predict(observation, episode_start=step == 0)
        observation, _, terminated, truncated, info = env.step(action)
        if terminated or truncated:
            break
    return agent.beliefs[0], info


def test_the_diagnoser_names_what_the_model_lacks_and_the_belief_grows_by_it() -> None:
    belief, info = played(200, diagnose=True, options={"hidden": "locked", "effects": [FRICTION]})
    assert info["is_success"]
    named = [update for update in belief.updates if update.named]
    assert [update.named for update in named] == [("coulomb_friction",)]
    assert named[0].time < 5.0
    found = {one["name"]: one["mean"] for one in belief.updates[-1].estimate}
    assert found["coulomb_friction.force"] == pytest.approx(55.0, rel=0.05)
    assert found["body.mass"] == pytest.approx(22.0, rel=0.05)


def test_where_nothing_is_missing_the_diagnoser_is_not_asked() -> None:
    belief, info = played(200, diagnose=True)
    assert info["is_success"]
    assert belief.diagnosed_at == 0.0
    assert not any(update.named for update in belief.updates)


def test_what_the_diagnoser_cannot_vouch_for_is_supposed_where_it_predicts_better(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    # Friction under a made-up object, which the diagnoser is made to offer without vouching for it.
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
    agent = trundle.AdaptiveAgent(env, diagnose=True)
    for step in range(84):
        action, _ = agent.predict(observation, episode_start=step == 0)
        observation = env.step(action)[0]
    (belief,) = agent.beliefs
    assert not any(update.named for update in belief.updates)
    (update,) = (update for update in belief.updates if update.supposed)
    assert "coulomb_friction" in update.supposed
    # It is fitted further: the values move.
    assert belief.updates[-1].time > update.time
    kinds = [{one["name"] for one in each.model.parameters} for each in (update, belief.updates[-1])]
    assert kinds[0] == kinds[1] and belief.updates[-1].model.to_toml() != update.model.to_toml()


def test_nothing_is_supposed_that_predicts_no_better() -> None:
    belief, _ = played(60)
    recording = belief.recording(0.05, 0.02)
    physics = Physics(None, diagnose=True, starts=1, seed=0)
    found = physics._fit(belief, recording)
    assert physics._supposed(recording, [{"effect": "coulomb_friction"}], found) is None
    assert physics._supposed(recording, [], found) is None


@pytest.mark.parametrize(
    ("law", "effect"),
    [
        ({"kind": "spin_drag", "spin": 40.0}, "second_wheel"),
        ({"kind": "support_friction", "force": 40.0, "spread": 1.0}, "coulomb_friction"),
    ],
)
def test_an_effect_is_supposed_by_the_law_that_explains_it(law: dict[str, Any], effect: str) -> None:
    belief, _ = played(64, options={"hidden": "locked", "effects": [law]})
    recording = belief.recording(0.05, 0.02)
    physics = Physics(None, diagnose=True, starts=2, seed=0)
    richer = physics._supposed(recording, [{"effect": effect}], physics._fit(belief, recording))
    assert richer is not None
    model, named, supposed = richer
    assert (named, supposed) == ((), (effect,))
    assert law["kind"] in {one["name"].split(".")[0] for one in model.parameters}


@pytest.mark.parametrize("learner", ["shooting", "linear"])
def test_other_learners_get_there_too(learner: str) -> None:
    belief, info = played(300, "trundle/LockedWheel-v0", learner=learner, seed=1)
    assert info["is_success"]
    assert belief.fits > 0
    assert (belief.regression is not None) == (learner == "linear")


def test_a_locally_weighted_regression_is_planned_on() -> None:
    belief, _ = played(24, "trundle/LockedWheel-v0", learner="local", samples=32, iterations=2)
    assert belief.regression is not None
    assert belief.regression.widths is not None


def test_it_plans_on_several_models_only_while_it_matters_which_is_true() -> None:
    belief, _ = played(60)
    values = [update.value_of_information for update in belief.updates]
    assert values[0] > 0.02 > values[-1]
    assert belief.models == (belief.model,)
    early, _ = played(5)
    assert len(early.models) == 5


def test_a_probing_agent_begins_with_suspicions_and_ends_as_sure() -> None:
    belief, _ = played(1, probe=True)
    assert len(belief.models) == 5
    belief, info = played(300, probe=True)
    assert info["is_success"]
    assert len(belief.models) == 1


def test_learning_can_end_after_some_pushes() -> None:
    belief, info = played(300, pushes=2)
    assert info["is_success"]
    assert belief.updates[-1].time == 1.0


def test_it_takes_hold_elsewhere_where_the_grasp_cannot_do_it() -> None:
    bed = {"hidden": "locked", "object": "bed"}
    kept, _ = played(300, "trundle/PushPose-v0", seed=3, options=bed)
    belief, info = played(300, "trundle/PushPose-v0", seed=3, options={**bed, "action": "regrasp"})
    assert info["is_success"]
    places = [update.regrasp for update in belief.updates if update.regrasp]
    assert places
    assert belief.latest.grasp == pytest.approx(places[-1])
    assert len(belief.observations) < 0.6 * len(kept.observations)


def test_a_gripper_that_lets_go_pushes_no_longer() -> None:
    # On an object that rolls freely every impulse is a change of velocity.
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


def test_along_a_path_the_goal_moves_and_it_goes_on_learning() -> None:
    belief, _ = played(60, "trundle/PushPath-v0")
    assert belief.updates[-1].time == 2.5
    assert belief.model.to_toml() != belief.updates[0].model.to_toml()


def test_of_several_objects_the_observation_tells_the_size() -> None:
    belief, info = played(300, options={"hidden": "locked", "object": ["chair", "bookcase"]}, seed=5)
    assert info["is_success"]
    corner = np.max(belief.metadata["object"]["footprint"], axis=0)
    assert corner == pytest.approx(belief.latest.half_size)


def test_an_oracle_follows_a_caster() -> None:
    caster = {"kind": "caster_swivel", "x": 0.5, "y": -0.3, "trail": 0.05, "mu_side": 150.0}
    env = gymnasium.make(AROUND, hidden="none", effects=[caster])
    observation, _ = env.reset(seed=2)
    source: Any = env.unwrapped
    model = trundle.Model.from_toml(tomli_w.dumps(source.hidden_model()))
    agent = trundle.AdaptiveAgent(env, model=model, adapt=False)
    for step in range(40):
        action, (belief,) = agent.predict(observation, episode_start=step == 0)
        observation = env.step(action)[0]
    (angle,) = belief.inner_states(0.05)
    assert Laws(model).starts != [angle]
    # The wheel trails behind the way its pivot goes, seen from the object.
    before, now = belief.observations[-6], belief.observations[-1]
    pivot = [seen.position + turned(np.array([0.5, -0.3]), seen.heading) for seen in (before, now)]
    way = np.arctan2(*(pivot[1] - pivot[0])[::-1]) - now.heading
    assert abs(np.angle(np.exp(1j * (angle - way)))) < 0.5 or (
        abs(np.angle(np.exp(1j * (angle - way + np.pi)))) < 0.5
    )


def turned(point: Any, angle: float) -> Any:
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([cos * point[0] - sin * point[1], sin * point[0] + cos * point[1]])


def test_a_wrench_is_carried_to_the_origin() -> None:
    # 10 N along y, half a metre in front of the origin.
    assert about_origin(np.array([0.0, 10.0, 1.0]), np.array([0.5, 0.2])).tolist() == [0.0, 10.0, 6.0]
    assert about_origin(np.array([10.0, 0.0, 0.0]), np.array([0.5, 0.2])).tolist() == [10.0, 0.0, -2.0]


@pytest.mark.parametrize(
    ("told", "reason"),
    [
        ({"learner": "neural"}, "learner = 'neural': choose one of filter, shooting, linear, local"),
        ({"learner": "linear", "diagnose": True}, "a regression cannot be diagnosed"),
        ({"adapt": False, "probe": True}, "these need adapt = True"),
        ({"curiosity": -1.0}, "curiosity"),
        ({"pushes": 0}, "pushes = 0"),
    ],
)
def test_what_makes_no_sense_is_refused(told: dict[str, Any], reason: str) -> None:
    env = gymnasium.make("trundle/LockedWheel-v0")
    with pytest.raises(trundle.TrundleError, match=reason):
        trundle.AdaptiveAgent(env, **told)
