"""Train PPO for two minutes to push a table with a hidden locked wheel (requires the extra [rl]).

python examples/train_ppo.py --steps 600000
"""

import argparse

import torch

from trundle.experiments.training.config import PPO
from trundle.experiments.training.evaluate import evaluate
from trundle.experiments.training.networks import algorithm, exported
from trundle.experiments.training.settings import Network, RewardShaping
from trundle.experiments.training.worlds import make_worlds

parser = argparse.ArgumentParser()
parser.add_argument("--steps", type=int, default=600_000, help="steps of all environments together")
parser.add_argument("--episodes", type=int, default=100, help="episodes of each evaluation")
parser.add_argument("--out", help="output file.npz of the policy, for `trundle play PushPose --agent`")
args = parser.parse_args()
torch.set_num_threads(1)  # more threads are slower with such small networks

# As in a file for `trundle train`, such as configs/rl/ppo.toml. Each episode hides another wheel.
settings = PPO(
    name="example",
    env="trundle/PushPose-v0",
    env_kwargs={"hidden": "locked", "action": "wrench"},
    n_timesteps=args.steps,
    seeds=[1],
    n_envs=128,
    frame="object",  # goal and velocity in the frame of the table
    n_steps=64,
    batch_size=2048,
    n_epochs=6,
    learning_rate=1e-3,
    policy_kwargs=Network(net_arch=[64, 64], log_std_init=-1.0),
    aids=RewardShaping(success_bonus=10.0, loss_cost=20.0),  # reward shaping; not part of the return
)
worlds = make_worlds(settings)
learner = algorithm(settings, 1, worlds)


def print_evaluation(when: str) -> None:
    """Print the number of goals reached in worlds that are not used for training."""
    policy = exported(settings, 1, learner, worlds)
    found = evaluate(policy, settings.env, settings.env_kwargs, 500_000, args.episodes)
    reached = round(found["success"] * args.episodes)
    print(f"{when}: {reached} of {args.episodes} goals reached, mean distance {found['distance']:.2f} m")


print_evaluation("before")
learner.learn(args.steps)
print_evaluation(f"after {learner.num_timesteps:,} steps")
if args.out:
    exported(settings, 1, learner, worlds).save(args.out)
