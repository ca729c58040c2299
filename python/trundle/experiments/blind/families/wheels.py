"""Wheels: a second wheel, and a wheel that locks or unlocks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np

from trundle.experiments.blind.family import EpisodeContext, Family, Hook, Values
from trundle.experiments.blind.scene import Scene, Wheel, draw_event, draw_wheel
from trundle.experiments.blind.world import add_wheel, set_wheel
from trundle.experiments.sampling import Floats


class SecondWheel(Family):
    """A second viscous wheel."""

    name = "second_wheel"
    scales = ("mu_x", "mu_y")

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return a wheel drawn like the first."""
        return dict(vars(draw_wheel(rng, scene.shape)))

    def add_to_world(self, context: EpisodeContext, values: Values) -> None:
        """Add the wheel."""
        add_wheel(context.spec, context.table, "second wheel", Wheel(**values))

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return the total damping matrix of both wheels about the object's origin."""
        whole = scene.wheel.damping() + Wheel(**values).damping()
        return {"parameters": {"damping": whole.tolist()}, "where": None}

    def laws(self, scene: Scene, values: Values) -> list[Values]:
        """Return the rotational damping that one equivalent wheel does not explain."""
        whole = scene.wheel.damping() + Wheel(**values).damping()
        lever = whole[:2, 2]
        spin = whole[2, 2] - lever @ np.linalg.solve(whole[:2, :2], lever)
        return [{"kind": "spin_drag", "spin": max(float(spin), 1e-3)}]


class WheelEvent(Family):
    """The wheel locks or unlocks at one time of a training episode, permanently."""

    name = "wheel_event"
    scales = ("log_x", "log_y")

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return a training episode, a time, and factors."""
        locks = rng.uniform(np.log(2.5), np.log(12.0)) * (1.0 if rng.random() < 0.5 else -1.0)
        return {
            **draw_event(rng, scene),
            "log_x": float(locks),
            "log_y": float(locks * rng.uniform(0.3, 1.0)),
        }

    def hook(self, model: Any, context: EpisodeContext, values: Values) -> Hook | None:
        """Change the wheel's actuators from that time on."""
        wheel, episode = context.scene.wheel, context.episode
        changed = (wheel.mu_x * np.exp(values["log_x"]), wheel.mu_y * np.exp(values["log_y"]))
        if episode > values["episode"]:
            set_wheel(model, "wheel", *changed)
        if episode != values["episode"]:
            return None

        def switch(data: mujoco.MjData) -> None:
            if data.time >= values["time"]:
                set_wheel(model, "wheel", *changed)

        return switch

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return factors and time."""
        factors = {f"factor_{axis}": float(np.exp(values[f"log_{axis}"])) for axis in "xy"}
        event = {"episode": f"episode_{values['episode']:02}", "time": values["time"]}
        return {"parameters": factors, "where": {"event": event}}

    def laws(self, scene: Scene, values: Values) -> list[Values]:
        """Return the event."""
        factors = self.truth(scene, values)["parameters"]
        return [{"kind": self.name, "episode": values["episode"], "time": values["time"], **factors}]
