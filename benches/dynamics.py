"""Prediction errors of dynamics models and of the adaptive agent's estimate on unseen objects.

python benches/dynamics.py docs/baselines/dynamics/hard_dynamics-1.npz --episodes 256

The test objects of a level are pushed as in the training data: half of them at random, the others towards the
goal. After some observed motion, the motion of the next second is predicted under the measured wrenches. The
adaptive agent's estimate is that of its default learner. It knows the bounding box, as the dynamics models
do. "First model" is its model before any observation.
"""

from __future__ import annotations

import argparse
import os
from pathlib import Path

os.environ.setdefault("RAYON_NUM_THREADS", "1")

import numpy as np
from numpy.typing import NDArray

import trundle
from trundle.belief import Belief
from trundle.envs import Observation
from trundle.envs.seen_outline import bounding_rectangle
from trundle.experiments.training.dynamics.card import error_table
from trundle.experiments.training.dynamics.collect import Episodes, collect
from trundle.experiments.training.dynamics.errors import OPEN_LOOP_S, errors_of_motion, prediction_errors
from trundle.experiments.training.dynamics.model import load
from trundle.experiments.training.dynamics.motion import motion_of
from trundle.first_models import freely_rolling_model
from trundle.learners import make_learner

PERIOD_S, RISE_S, MASS_KG = 0.05, 0.02, 22.0
HISTORIES_S = (0.0, 0.5, 1.0, 3.0)
STEPS = round((max(HISTORIES_S) + OPEN_LOOP_S) / PERIOD_S)


def physical_errors(episodes: Episodes, after: float, adapt: bool) -> dict[str, float]:
    """Return the errors of the agent's physical model; see `prediction_errors`."""
    start, steps = round(after / PERIOD_S), round(OPEN_LOOP_S / PERIOD_S)
    chosen = episodes.valid[: start + steps].all(axis=0)
    observations = episodes.observations[: start + steps + 1, chosen]
    states = [predicted(one, start, adapt) for one in np.moveaxis(observations, 1, 0)]
    return errors_of_motion(np.stack(states), Observation(observations[start:]))


def predicted(observations: NDArray[np.float64], start: int, adapt: bool) -> NDArray[np.float64]:
    """Return the predicted states of an episode, shape (steps, 6), after `start` steps."""
    first = Observation(observations[0])
    description = {"footprint": bounding_rectangle(first, has_middle=True).tolist()}
    model = freely_rolling_model(description, MASS_KG)
    if adapt and start:
        belief = Belief(model, trundle.Planner([-1] * 3, [1] * 3), {"object": description}, first)
        learner = make_learner("body", None, starts=2, seed=0)
        for row in observations[1 : start + 1]:
            belief.observe(Observation(row))
            learner.learn(belief, PERIOD_S, RISE_S)
        model = belief.model
    wrenches = motion_of(observations[start:, None]).inputs[:, 0, 3:]
    times = PERIOD_S * np.arange(len(wrenches))
    t = np.concatenate([np.stack([times, times + RISE_S], axis=1).ravel(), [times[-1] + PERIOD_S]])
    knots = np.concatenate([wrenches.reshape(-1, 3), wrenches[-1:, 3:]])
    now = Observation(observations[start])
    poses, twists = model.rollout(now.pose, now.twist, t, knots)
    return np.concatenate([poses, twists], axis=1)[2::2]


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("files", nargs="*", type=Path, help="dynamics models of `trundle train`")
    parser.add_argument("--episodes", type=int, default=256)
    parser.add_argument("--seed", type=int, default=130_000, help="seed of the first episode")
    parser.add_argument("--env", default="trundle/PushPoseHard-v1")
    args = parser.parse_args()
    episodes = collect(args.env, {"split": "test"}, args.seed, args.episodes, STEPS, 0.5)
    for file in args.files:
        model = load(file)
        rows = [{"history": after, **prediction_errors(model, episodes, after)} for after in HISTORIES_S]
        print(f"\n{file}\n\n{error_table(rows)}", flush=True)
    for title, adapt in (("First model", False), ("Adaptive agent's estimate", True)):
        rows = [{"history": after, **physical_errors(episodes, after, adapt)} for after in HISTORIES_S]
        print(f"\n{title}\n\n{error_table(rows)}", flush=True)


if __name__ == "__main__":
    main()
