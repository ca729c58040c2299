"""Coverage of 90 % intervals if the true law differs slightly from the model."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import trundle

CONFIGS = Path(__file__).resolve().parents[2] / "configs"
TRUTH = {
    "body.mass": 22.0,
    "viscous_wheel.x": -0.5,
    "viscous_wheel.y": 0.3,
    "viscous_wheel.angle": 0.3,
    "viscous_wheel.mu_x": 60.0,
    "viscous_wheel.mu_y": 180.0,
}
RECORDINGS = 16
EPISODES = 6
SCENARIO = """
format = "trundle-scenario/1"
name = "pushes"
object = "{objects}/office_table.toml"
held_out = 1

[[effect]]
kind = "viscous_wheel"
x = -0.5
y = 0.3
angle = 0.3
mu_x = {mu_x}
mu_y = {mu_y}
{more}
[sensor]
rate = 100.0
[tracker]
rate = 50.0
[random]
count = {count}
duration = 3.0
speed = 0.3
spin = 0.5
"""


def pushes(folder: Path, seed: int, count: int, factor: float = 1.0, more: str = "") -> trundle.Recording:
    """Simulate pushes whose wheel has `factor` times the friction of `TRUTH`; the last push is held out."""
    mu_x, mu_y = factor * TRUTH["viscous_wheel.mu_x"], factor * TRUTH["viscous_wheel.mu_y"]
    text = SCENARIO.format(objects=CONFIGS / "objects", mu_x=mu_x, mu_y=mu_y, count=count, more=more)
    path = folder / "scenario.toml"
    path.write_text(text, encoding="utf-8")
    return trundle.simulate(path, seed=seed)


def uneven(folder: Path, seed: int) -> trundle.Recording:
    """Simulate a floor whose friction varies by 4 % (one standard deviation) between pushes."""
    rng = np.random.default_rng(seed)
    episodes = {}
    for k in range(EPISODES):
        factor = 1.0 + 0.04 * rng.normal()
        one = pushes(folder, 100 * seed + k, 2, factor)
        episodes[f"episode_{k:02}"] = one.episodes["episode_00"]
        metadata = one.metadata
    metadata = dict(metadata) | {"split": {"held_out": []}}
    del metadata["split"]
    if isinstance(metadata["wrench"].get("precontact"), dict):
        spans = metadata["wrench"]["precontact"]
        metadata["wrench"] = metadata["wrench"] | {"precontact": dict.fromkeys(episodes, spans["episode_00"])}
    return trundle.Recording(metadata, episodes)


def rubbing(folder: Path, seed: int) -> trundle.Recording:
    """Simulate a foot that rubs with 0.3 N, 1 % of the pushing force."""
    foot = '\n[[effect]]\nkind = "coulomb_friction"\nx = 0.5\ny = -0.3\nforce = 0.3\n'
    return pushes(folder, seed, EPISODES + 1, more=foot)


def coverage(recordings: list[trundle.Recording]) -> float:
    """Return the share of 90 % intervals that cover the truth."""
    inside = []
    for recording in recordings:
        summary = trundle.fit(recording, start=TRUTH, starts=0).summary
        assert summary["intervals"]["basis"] == "sandwich"
        inside += [p["low"] <= TRUTH[p["name"]] <= p["high"] for p in summary["parameters"]]
    return float(np.mean(inside))


def test_intervals_cover_if_the_floor_varies_between_pushes(tmp_path: Path) -> None:
    """The error varies between pushes, which the covariance includes."""
    assert 0.82 <= coverage([uneven(tmp_path, seed) for seed in range(RECORDINGS)]) <= 0.97


def test_intervals_cover_mostly_if_a_foot_rubs(tmp_path: Path) -> None:
    """A missing effect also causes a common bias of all pushes, which no interval includes."""
    assert coverage([rubbing(tmp_path, seed) for seed in range(RECORDINGS)]) >= 0.5
