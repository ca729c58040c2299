"""Push a table with a hidden locked wheel to a goal with the adaptive agent.

python examples/adaptive_agent.py --seed 0
"""

import argparse

import gymnasium

import trundle

parser = argparse.ArgumentParser()
parser.add_argument(
    "--seed", type=int, default=0, help="seed of the table, its wheel, the start and the goal (default 0)"
)
seed = parser.parse_args().seed

env = gymnasium.make("trundle/LockedWheel-v0")
agent = trundle.AdaptiveAgent(env)

observation, info = env.reset(seed=seed)
fields = trundle.envs.Observation(observation)
distance = float(((fields.position - fields.goal_position) ** 2).sum() ** 0.5)
print(f"{distance:.2f} m to the goal; in the first model the table rolls freely")

# A step of the environment takes 50 ms. While it matters which model is true, the agent estimates the paper's
# model (a rigid body with one viscous wheel) from all observations and plans before each step. After that it
# plans every 0.1 s and estimates every 0.5 s.
fits, steps, done = 0, 0, False
while not done:
    action, (belief,) = agent.predict(observation, episode_start=steps == 0)
    if belief.fits > fits:
        fits = belief.fits
        wheel = {p["name"].removeprefix("viscous_wheel."): p["value"] for p in belief.model.parameters}
        print(
            f"{0.05 * steps:4.1f} s: mass {wheel['body.mass']:4.1f} kg, wheel at ({wheel['x']:5.2f}, "
            f"{wheel['y']:5.2f}) m with drag {wheel['mu_x']:3.0f} and {wheel['mu_y']:3.0f} N s/m"
        )
    observation, reward, terminated, truncated, info = env.step(action)
    steps, done = steps + 1, terminated or truncated

reached = "reached" if info["is_success"] else "not reached"
print(
    f"{reached} after {0.05 * steps:.2f} s: error {info['distance']:.3f} m, {info['heading_error']:.3f} rad"
)
