"""PPO in one file, with the loop of CleanRL's ppo_continuous_action.py and its wrappers.

python examples/train_cleanrl.py --total-timesteps 4096
"""

import argparse

import gymnasium as gym
import numpy as np
import torch
from torch import nn
from torch.distributions.normal import Normal

import trundle  # noqa: F401 (registers the environments)

parser = argparse.ArgumentParser()
parser.add_argument("--env-id", default="trundle/PushAroundEasy-v1")
parser.add_argument("--total-timesteps", type=int, default=4096)
parser.add_argument("--num-envs", type=int, default=4)
parser.add_argument("--num-steps", type=int, default=256)
parser.add_argument("--seed", type=int, default=1)
args = parser.parse_args()

GAMMA, LAMBDA, CLIP, EPOCHS, MINIBATCHES = 0.99, 0.95, 0.2, 4, 8


def make_env(env_id: str) -> gym.Env:
    """Make an environment with CleanRL's wrappers."""
    env = gym.make(env_id, dtype="float32")
    env = gym.wrappers.FlattenObservation(env)
    env = gym.wrappers.RecordEpisodeStatistics(env)
    env = gym.wrappers.ClipAction(env)
    env = gym.wrappers.NormalizeObservation(env)
    env = gym.wrappers.NormalizeReward(env, gamma=GAMMA)
    return gym.wrappers.TransformReward(env, lambda reward: float(np.clip(reward, -10, 10)))


def layers(count: int, outputs: int, gain: float) -> nn.Sequential:
    """Return a network with two hidden layers."""
    net = nn.Sequential(nn.Linear(count, 64), nn.Tanh(), nn.Linear(64, 64), nn.Tanh(), nn.Linear(64, outputs))
    nn.init.orthogonal_(net[-1].weight, gain)
    return net


torch.set_num_threads(1)
torch.manual_seed(args.seed)
envs = gym.vector.SyncVectorEnv([lambda: make_env(args.env_id) for _ in range(args.num_envs)])
entries, width = envs.single_observation_space.shape[0], envs.single_action_space.shape[0]
actor, critic = layers(entries, width, 0.01), layers(entries, 1, 1.0)
log_sd = nn.Parameter(torch.zeros(width))
weights = [*actor.parameters(), *critic.parameters(), log_sd]
optimizer = torch.optim.Adam(weights, lr=3e-4, eps=1e-5)

shape = (args.num_steps, args.num_envs)
obs, actions = torch.zeros((*shape, entries)), torch.zeros((*shape, width))
logprobs, rewards, dones, values = (torch.zeros(shape) for _ in range(4))
seen, _ = envs.reset(seed=args.seed)
next_obs, next_done = torch.tensor(seen), torch.zeros(args.num_envs)
returns: list[float] = []

for _ in range(args.total_timesteps // (args.num_steps * args.num_envs)):
    for step in range(args.num_steps):
        obs[step], dones[step] = next_obs, next_done
        with torch.no_grad():
            chosen = Normal(actor(next_obs), log_sd.exp())
            actions[step] = chosen.sample()
            logprobs[step] = chosen.log_prob(actions[step]).sum(1)
            values[step] = critic(next_obs).flatten()
        seen, reward, terminated, truncated, infos = envs.step(actions[step].numpy())
        rewards[step] = torch.tensor(reward)
        next_obs = torch.tensor(seen)
        next_done = torch.tensor(terminated | truncated, dtype=torch.float32)
        if "episode" in infos:
            returns += infos["episode"]["r"][infos["_episode"]].tolist()
    with torch.no_grad():
        advantages, last = torch.zeros(shape), torch.zeros(args.num_envs)
        following, alive = critic(next_obs).flatten(), 1.0 - next_done
        for step in reversed(range(args.num_steps)):
            delta = rewards[step] + GAMMA * following * alive - values[step]
            advantages[step] = last = delta + GAMMA * LAMBDA * alive * last
            following, alive = values[step], 1.0 - dones[step]
        targets = advantages + values
    flat = [part.flatten(0, 1) for part in (obs, actions, logprobs, advantages, targets)]
    for _ in range(EPOCHS):
        for rows in torch.randperm(args.num_steps * args.num_envs).chunk(MINIBATCHES):
            b_obs, b_actions, b_logprobs, b_advantages, b_targets = (part[rows] for part in flat)
            ratio = (Normal(actor(b_obs), log_sd.exp()).log_prob(b_actions).sum(1) - b_logprobs).exp()
            normal = (b_advantages - b_advantages.mean()) / (b_advantages.std() + 1e-8)
            policy_loss = -torch.min(ratio * normal, ratio.clamp(1 - CLIP, 1 + CLIP) * normal).mean()
            loss = policy_loss + 0.25 * (critic(b_obs).flatten() - b_targets).square().mean()
            optimizer.zero_grad()
            loss.backward()
            nn.utils.clip_grad_norm_(weights, 0.5)
            optimizer.step()
    recent = np.mean(returns[-20:]) if returns else float("nan")
    print(f"{len(returns)} episodes, mean return of the last 20: {recent:.1f}")
