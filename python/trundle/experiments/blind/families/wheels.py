"""Wheels: one more of them, and one that locks or comes free."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from trundle.experiments.blind.family import EpisodeContext, Family, Hook, Values
from trundle.experiments.blind.scene import Scene, Wheel, draw_event, draw_wheel
from trundle.experiments.blind.world import add_wheel, set_wheel

Floats = NDArray[np.float64]


class SecondWheel(Family):
    """One more viscous wheel elsewhere."""

    name = "second_wheel"
    scales = ("mu_x", "mu_y")

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return a wheel as the first is drawn."""
        return dict(vars(draw_wheel(rng, scene.shape)))

    def add_to_world(self, context: EpisodeContext, values: Values) -> None:
        """Add it."""
        add_wheel(context.spec, context.table, "second wheel", Wheel(**values))

    def truth(self, scene: Scene, values: Values) -> Values:
        """Return the damping of both together about the object's origin."""
        whole = scene.wheel.damping() + Wheel(**values).damping()
        return {"parameters": {"damping": whole.tolist()}, "where": None}

    def laws(self, scene: Scene, values: Values) -> list[Values]:
        """Return the damping of the spin that one wheel in the place of both leaves over."""
        whole = scene.wheel.damping() + Wheel(**values).damping()
        lever = whole[:2, 2]
        spin = whole[2, 2] - lever @ np.linalg.solve(whole[:2, :2], lever)
        return [{"kind": "spin_drag", "spin": max(float(spin), 1e-3)}]


class WheelEvent(Family):
    """At one moment of a training episode the wheel locks or comes free, for good."""

    name = "wheel_event"
    scales = ("log_x", "log_y")

    def draw(self, rng: np.random.Generator, scene: Scene, paths: Sequence[Floats]) -> Values:
        """Return an episode that is not held out, a time, and factors."""
        locks = rng.uniform(np.log(2.5), np.log(12.0)) * (1.0 if rng.random() < 0.5 else -1.0)
        return {
            **draw_event(rng, scene),
            "log_x": float(locks),
            "log_y": float(locks * rng.uniform(0.3, 1.0)),
        }

    def hook(self, model: Any, context: EpisodeContext, values: Values) -> Hook | None:
        """Change the wheel's actuators from that moment on."""
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
        """Return factors and moment."""
        factors = {f"factor_{axis}": float(np.exp(values[f"log_{axis}"])) for axis in "xy"}
        event = {"episode": f"episode_{values['episode']:02}", "time": values["time"]}
        return {"parameters": factors, "where": {"event": event}}

    def laws(self, scene: Scene, values: Values) -> list[Values]:
        """Return the event."""
        factors = self.truth(scene, values)["parameters"]
        return [{"kind": self.name, "episode": values["episode"], "time": values["time"], **factors}]
