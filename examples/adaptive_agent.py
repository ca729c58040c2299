"""Push a table with a locked wheel to a goal, learning where the wheel is on the way.

python examples/adaptive_agent.py --seed 0
"""

import argparse

import gymnasium

import trundle

parser = argparse.ArgumentParser()
parser.add_argument("--seed", type=int, default=0, help="of the table, its wheel, start and goal")
seed = parser.parse_args().seed

env = gymnasium.make("trundle/LockedWheel-v0")
agent = trundle.AdaptiveAgent(env)

observation, info = env.reset(seed=seed)
fields = trundle.envs.Observation(observation)
distance = float(((fields.position - fields.goal_position) ** 2).sum() ** 0.5)
print(f"{distance:.2f} m to go; the agent believes that the table rolls freely")

# One turn of the loop: the agent pushes for 50 ms and looks. As long as it matters which model is true, it
# fits the paper's, a rigid body with one viscous wheel, to all that it has seen, and plans anew each time;
# after that it plans each 0.1 s and fits each 0.5 s.
fits, steps, done = 0, 0, False
while not done:
    action, (belief,) = agent.predict(observation, episode_start=steps == 0)
    if belief.fits > fits:
        fits = belief.fits
        wheel = {p["name"].removeprefix("viscous_wheel."): p["value"] for p in belief.model.parameters}
        print(
            f"{0.05 * steps:4.1f} s: a table of {wheel['body.mass']:4.1f} kg, a wheel at ({wheel['x']:5.2f}, "
            f"{wheel['y']:5.2f}) m that resists with {wheel['mu_x']:3.0f} and {wheel['mu_y']:3.0f} N s/m"
        )
    observation, reward, terminated, truncated, info = env.step(action)
    steps, done = steps + 1, terminated or truncated

reached = "reached" if info["is_success"] else "not reached"
print(f"{reached} after {0.05 * steps:.2f} s: {info['distance']:.3f} m, {info['heading_error']:.3f} rad off")
