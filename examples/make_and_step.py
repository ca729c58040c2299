"""Make an environment and step it: a single one, branches of it, and a batch of a thousand.

Run it with `python examples/make_and_step.py`; it writes `make_and_step.png`.
"""

from __future__ import annotations

import gymnasium
import matplotlib.pyplot as plt
import numpy as np

import trundle

# A random piece of furniture with one locked wheel, and a doorway.
env = gymnasium.make("trundle/PushDoor-v0", render_mode="rgb_array")
observation, info = env.reset(seed=7)
print(f"an observation has {len(observation)} numbers, an action three in [-1, 1]")

# An action is a share of the full wrench, which is the same for all objects.
push = np.array([0.8, 0.1, 0.0], dtype=np.float32)
for _ in range(20):
    observation, reward, terminated, truncated, info = env.step(push)
    if terminated or truncated:
        break
velocity = trundle.envs.Observation(observation).velocity
print(f"after a second: {info['distance']:.2f} m from the goal, at {velocity.round(2)} m/s")

# Try three actions for the next second from the same state. A snapshot includes random numbers and clock.
task = env.unwrapped
assert isinstance(task, trundle.envs.Push)
here = task.snapshot()
for torque in (-0.5, 0.0, 0.5):
    task.restore(here)
    for _ in range(20):
        *_, info = env.step(np.array([0.8, 0.0, torque], dtype=np.float32))
        if info["lost"] or info["is_success"]:
            break
    print(f"torque {torque:4.1f}: {info['distance']:.2f} m from the goal")
plt.imsave("make_and_step.png", np.asarray(env.render()))

# A batch of a thousand worlds; each is bit-identical to the single environment with its seed.
envs = gymnasium.make_vec("trundle/PushDoor-v0", num_envs=1000)
observations, _ = envs.reset(seed=0)
for _ in range(20):
    observations, rewards, terminated, truncated, infos = envs.step(np.tile(push, (1000, 1)))
print(f"of 1000, {int(infos['touched'].sum())} touch a wall now")
