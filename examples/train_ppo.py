"""Let PPO learn for two minutes to push a table with a hidden locked wheel (needs the extra [rl]).

python examples/train_ppo.py --steps 600000
"""

import argparse

import torch

from trundle.experiments.training.config import PPO, Network, RewardShaping
from trundle.experiments.training.evaluate import evaluate
from trundle.experiments.training.networks import algorithm, exported
from trundle.experiments.training.worlds import make_worlds

parser = argparse.ArgumentParser()
parser.add_argument("--steps", type=int, default=600_000, help="of all environments together")
parser.add_argument("--episodes", type=int, default=100, help="of each evaluation")
parser.add_argument("--out", help="keep the policy: a file.npz that `trundle play PushPose --agent` takes")
args = parser.parse_args()
torch.set_num_threads(1)  # the networks are small: more threads would wait for each other

# A file for `trundle train`, such as configs/rl/ppo.toml, says the same. Each episode hides another wheel.
settings = PPO(
    name="example",
    env="trundle/PushPose-v0",
    env_kwargs={"hidden": "locked", "action": "wrench"},
    n_timesteps=args.steps,
    seeds=[1],
    n_envs=128,
    frame="object",  # the network sees goal and velocity from the table, as a person behind it does
    n_steps=64,
    batch_size=2048,
    n_epochs=6,
    learning_rate=1e-3,
    policy_kwargs=Network(net_arch=[64, 64], log_std_init=-1.0),
    aids=RewardShaping(success_bonus=10.0, loss_cost=20.0),  # to learn from; not part of the return
)
worlds = make_worlds(settings)
learner = algorithm(settings, 1, worlds)


def tell(when: str) -> None:
    """Play worlds that are never trained on, and say how many goals are reached."""
    policy = exported(settings, 1, learner, worlds)
    found = evaluate(policy, settings.env, settings.env_kwargs, 500_000, args.episodes)
    reached = round(found["success"] * args.episodes)
    print(f"{when}: {reached} of {args.episodes} goals reached, {found['distance']:.2f} m off on average")


tell("before")
learner.learn(args.steps)
tell(f"after {learner.num_timesteps:,} steps")
if args.out:
    exported(settings, 1, learner, worlds).save(args.out)
