"""`trundle.fit(likelihood=…)`: each choice, several recordings, parameters per episode."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trundle
from trundle.cli import main

Cart = Callable[..., trundle.Recording]
CHOICES = ["filter", "steps", "final", "windows", "wrench"]
TRUTH = {"body.mass": 15.0, "viscous_wheel.mu_x": 10.0, "viscous_wheel.mu_y": 30.0}


def means(fit: trundle.Fit) -> dict[str, float | None]:
    return {parameter["name"]: parameter["mean"] for parameter in fit.summary["parameters"]}


def changed(recording: trundle.Recording, change: Callable[[dict[str, Any]], None]) -> trundle.Recording:
    """Return the recording with each episode's columns changed in place."""
    episodes: dict[str, dict[str, Any]] = {}
    for name, columns in recording.items():
        episodes[name] = {key: np.array(column) for key, column in columns.items()}
        change(episodes[name])
    return trundle.Recording(recording.metadata, episodes)


@pytest.mark.parametrize("likelihood", CHOICES)
def test_each_likelihood_finds_mass_and_friction(cart: Cart, model: trundle.Model, likelihood: Any) -> None:
    fit = trundle.fit(cart(), model, likelihood=likelihood)
    assert fit.summary["likelihood"] == likelihood and fit.summary["loss"] == "gaussian"
    for name, truth in TRUTH.items():
        assert means(fit)[name] == pytest.approx(truth, rel=0.12), name
    noise = [name for name in means(fit) if name.startswith("noise.")]
    assert bool(noise) == (likelihood != "filter")
    assert "noise." not in fit.model.to_toml()


def test_two_recordings_are_more_informative_than_one(cart: Cart, model: trundle.Model) -> None:
    recordings = [cart(seed=seed) for seed in (1, 2)]

    def sd(fit: trundle.Fit) -> float:
        return float(fit.summary["parameters"][0]["sd"])

    for likelihood in ("filter", "windows"):
        each = [sd(trundle.fit(one, model, likelihood=likelihood)) for one in recordings]
        assert sd(trundle.fit(recordings, model, likelihood=likelihood)) < min(each)


def test_episodes_may_have_separate_masses(cart: Cart, model: trundle.Model) -> None:
    recordings = [cart(mass=15.0, name="empty"), cart(mass=21.0, name="loaded")]
    fit = trundle.fit(recordings, model, likelihood="windows", per_episode=["body.mass"])
    for name, mass in means(fit).items():
        if name.startswith("body.mass["):
            assert mass == pytest.approx(21.0 if "loaded" in name else 15.0, rel=0.05), name
    assert sum(name.startswith("body.mass[") for name in means(fit)) == 4


def test_recordings_of_different_objects_are_refused(cart: Cart) -> None:
    first, second = cart(name="one"), cart(name="two")
    footprint = [[-0.4, -0.3], [0.5, -0.3], [0.5, 0.3], [-0.4, 0.3]]
    wider = second.metadata | {"object": second.metadata["object"] | {"footprint": footprint}}
    with pytest.raises(trundle.TrundleError, match=r'"one" and "two".*footprint'):
        trundle.fit([first, trundle.Recording(wider, second.episodes)])
    weighed = [
        trundle.Recording(one.metadata | {"object": one.metadata["object"] | {"mass": mass}}, one.episodes)
        for one, mass in ((first, 15.0), (second, 16.0))
    ]
    with pytest.raises(trundle.TrundleError, match=r'"one" and "two".*mass is 15 kg.*16 kg'):
        trundle.fit(weighed)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"likelihood": "guess"}, "choose one of filter"),
        ({"loss": "cauchy", "likelihood": "windows"}, "gaussian"),
        ({"loss": "student"}, "the filter requires normal residuals"),
        ({"likelihood": "windows", "window": 0.0}, "window of 0 s"),
        ({"per_episode": ["body.weight"]}, "body.weight"),
    ],
)
def test_an_invalid_choice_is_refused(cart: Cart, arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(trundle.TrundleError, match=message):
        trundle.fit(cart(), **arguments)


@pytest.mark.parametrize("likelihood", CHOICES)
def test_a_recording_without_motion_gives_no_number(
    cart: Cart, model: trundle.Model, likelihood: Any
) -> None:
    def rest(columns: dict[str, Any]) -> None:
        for key in ("object_x", "object_y", "object_theta"):
            first = columns[key][np.isfinite(columns[key])][0]
            columns[key][np.isfinite(columns[key])] = first
        for key in ("force_x", "force_y", "torque_z"):
            columns[key][:] = np.where(np.isfinite(columns[key]), np.nanmedian(columns[key][:40]), np.nan)

    no_number(changed(cart(), rest), model, likelihood)


@pytest.mark.parametrize("likelihood", CHOICES)
def test_a_recording_without_force_gives_no_number(cart: Cart, model: trundle.Model, likelihood: Any) -> None:
    def idle(columns: dict[str, Any]) -> None:
        for key in ("force_x", "force_y", "torque_z"):
            columns[key][np.isfinite(columns[key])] = 0.0

    no_number(changed(cart(), idle), model, likelihood, of=("body.mass",))


@pytest.mark.parametrize("likelihood", CHOICES)
@pytest.mark.parametrize("stream", ["object", "force"])
def test_a_recording_without_samples_is_an_error(
    cart: Cart, model: trundle.Model, likelihood: Any, stream: str
) -> None:
    def mask(columns: dict[str, Any]) -> None:
        for key in columns:
            if key.startswith(("object", "gripper") if stream == "object" else ("force", "torque")):
                kept = np.flatnonzero(np.isfinite(columns[key]))[:1]
                columns[key][np.setdiff1d(np.arange(len(columns[key])), kept)] = np.nan
        some = np.any([np.isfinite(column) for key, column in columns.items() if key != "t"], axis=0)
        for key in columns:
            columns[key] = columns[key][some]

    with pytest.raises(trundle.TrundleError, match=r"episode_00|recording|pre-?contact"):
        trundle.fit(changed(cart(), mask), model, likelihood=likelihood)


def no_number(
    recording: trundle.Recording, model: trundle.Model, likelihood: Any, of: tuple[str, ...] = tuple(TRUTH)
) -> None:
    """Assert that a fit ends in a clear error, or in parameters that are not identifiable."""
    try:
        found = means(trundle.fit(recording, model, likelihood=likelihood))
    except trundle.TrundleError as error:
        assert "motion" in str(error) or "pose" in str(error) or "load" in str(error)
    else:
        assert [found[name] for name in of] == [None] * len(of)


def test_the_command_accepts_several_recordings(
    cart: Cart, model: trundle.Model, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    paths = [tmp_path / "one", tmp_path / "two"]
    for seed, path in enumerate(paths):
        cart(seed=seed, name=path.name).write(path)
    model.write(tmp_path / "model.toml")
    line = ["fit", *map(str, paths), "--model", str(tmp_path / "model.toml"), "--json", "--quiet"]
    assert main([*line, "--likelihood", "windows", "--window", "0.5", "--loss", "student"]) == 0
    summary = json.loads(capsys.readouterr().out)
    assert (summary["likelihood"], summary["loss"]) == ("windows", "student")
    assert summary["recording"] == "one + two"
    assert summary["parameters"][0]["mean"] == pytest.approx(15.0, rel=0.05)
    assert main([*line, "--likelihood", "windows", "--per-episode", "body.weight"]) != 0
    assert "body.weight" in capsys.readouterr().err
