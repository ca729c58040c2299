"""Transitions, and regressions on them."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import trundle
from trundle.baselines import (
    Features,
    LinearRegression,
    LocallyWeightedRegression,
    PhysicalModel,
    Transitions,
    noise_sd,
    r2,
)

CONFIGS = Path(__file__).parents[2] / "configs"
OBJECTS = sorted((CONFIGS / "objects").glob("*.toml"))


def model(name: str, configuration: str) -> trundle.Model:
    return trundle.objects.read(CONFIGS / "objects" / f"{name}.toml").models[configuration]


def of_cart(n: int, seed: int) -> Transitions:
    return Transitions.simulated(model("shopping_cart", "fixed rear wheels"), n, seed=seed)


@pytest.mark.parametrize("path", OBJECTS, ids=lambda path: path.stem)
def test_every_object_states_its_sources(path: Path) -> None:
    task_object = trundle.objects.read(path)
    assert task_object.radius and task_object.models
    assert {"radius", "body.mass"} <= set(task_object.sources)
    for value, source in task_object.sources.items():
        assert source, value
    for configuration, ready in task_object.models.items():
        assert all(slot["value"] is not None for slot in ready.parameters), configuration


@pytest.mark.parametrize("name", ["kitchen_table", "couch", "desk", "chair", "bookcase"])
def test_objects_without_a_wheel_are_linear(name: str) -> None:
    free = model(name, "free")
    training, test = (Transitions.simulated(free, n, seed=seed) for n, seed in [(50, 0), (200, 1)])
    assert LinearRegression().fit(training).score(test) > 0.995


@pytest.mark.parametrize(
    "name, configuration",
    [("office_table", "locked"), ("shopping_cart", "fixed rear wheels"), ("bed", "steering castor")],
)
def test_objects_with_a_wheel_are_nonlinear(name: str, configuration: str) -> None:
    held = model(name, configuration)
    training, test = (Transitions.simulated(held, 200, seed=seed) for seed in [0, 1])
    linear = LinearRegression().fit(training).score(test)
    assert linear < 0.995
    assert LocallyWeightedRegression().fit(training).score(test) > linear
    assert PhysicalModel(held).score(test) == pytest.approx(1.0, abs=1e-12)


def test_linear_regression_is_exact_for_linear_transitions() -> None:
    rng = np.random.default_rng(0)
    before, wrench = rng.normal(size=(40, 6)), rng.normal(size=(40, 3))
    slopes = rng.normal(size=(9, 6))
    after = before + 0.2 * (np.hstack([before, wrench]) @ slopes + 0.3)
    data = Transitions(before, wrench, np.array(0.2), after)
    exact = LinearRegression("recorded").fit(data[:15])
    np.testing.assert_allclose(exact.predict(before, wrench, 0.2), after, atol=1e-9)
    assert LinearRegression("recorded").fit(data[:8]).score(data) < 0.99


@pytest.mark.parametrize("features", ["world", "body"])
def test_locally_weighted_regression_improves_with_data(features: Features) -> None:
    test = of_cart(200, 1)
    scores = [LocallyWeightedRegression(features).fit(of_cart(n, 0)).score(test) for n in (15, 50, 200)]
    left = [1.0 - score for score in scores]
    assert left[0] > 1.5 * left[1] > 2.0 * left[2]


def test_r2_by_hand() -> None:
    after = np.zeros((2, 6))
    after[:, 1], after[:, 2] = [1.0, 3.0], [0.0, 2.0]
    predicted = np.zeros((2, 6))
    predicted[:, 1] = 2.0
    # y: 1 - 2/2; theta: 1 - 4/2; the others do not vary.
    assert r2(predicted, after) == pytest.approx((0.0 - 1.0) / 2.0)
    assert r2(after, after) == 1.0
    assert np.isnan(r2(predicted[:1], after[:1]))
    predicted[0, 1] = np.nan
    assert r2(predicted, after) == -np.inf


def test_noise_has_the_units_of_its_interpretation() -> None:
    data = of_cart(3000, 0)
    for reading, first, heading in [("si", 0.5, 0.5), ("cm_deg", 0.005, np.radians(0.5))]:
        sd = noise_sd(0.5, reading, data)  # type: ignore[arg-type]
        np.testing.assert_allclose(sd, [first, first, heading] * 2)
    sd = noise_sd(0.5, "of_motion", data)
    np.testing.assert_allclose(sd, 0.5 * (data.after - data.before).std(axis=0))
    noisy = data.with_noise(sd, seed=4)
    np.testing.assert_allclose((noisy.after - data.after).std(axis=0), sd, rtol=0.05)
    np.testing.assert_array_equal(noisy.before, data.before)
    np.testing.assert_array_equal(noisy.after, data.with_noise(sd, seed=4).after)


def test_a_recording_gives_transitions() -> None:
    recording = trundle.simulate(CONFIGS / "experiments" / "demo.toml")
    training = Transitions.recorded(recording, dt=0.2)
    held_out = Transitions.recorded(recording, dt=0.2, held_out=True)
    # Six training and two held-out episodes of 6 s, without the time before contact and drop-outs.
    assert 100 < len(training) <= 180 and 30 < len(held_out) <= 60
    np.testing.assert_allclose(training.dt, 0.2, atol=0.03)
    smooth = trundle.smooth(recording)
    states = np.vstack([np.hstack([motion["pose"], motion["twist"]]) for motion in smooth.values()])
    for row in training.before[::20]:
        assert (np.abs(states - row).max(axis=1) < 1e-12).any()
    moving = Transitions(held_out.before, held_out.wrench, held_out.dt, held_out.before)
    body = LinearRegression("body").fit(training).score(held_out)
    assert body > r2(moving.after, held_out.after) + 0.01
    assert body > 0.9


def test_the_true_model_predicts_a_recording_better_than_any_regression() -> None:
    demo = CONFIGS / "experiments" / "demo.toml"
    recording = trundle.simulate(demo)
    training = Transitions.recorded(recording)
    held_out = Transitions.recorded(recording, held_out=True)
    hidden = demo.read_text().split("[[effect]]", 1)[1].split("[sensor]")[0]
    table = trundle.objects.read(CONFIGS / "objects" / "office_table.toml").bare.to_toml()
    truth = PhysicalModel(trundle.Model.from_toml(table + "[[effect]]" + hidden)).score(held_out)
    assert truth > 0.99
    for features in ("world", "body"):
        assert LinearRegression(features).fit(training).score(held_out) < truth
        assert LocallyWeightedRegression(features).fit(training).score(held_out) < truth


def test_invalid_arguments_are_named() -> None:
    data = of_cart(5, 0)
    free = trundle.Model.from_toml('format = "trundle-model/1"\n')
    for call, words in [
        (
            lambda: Transitions(data.before[:, :5], data.wrench, data.dt, data.after),
            "before: has the shape (5, 5)",
        ),
        (lambda: Transitions(data.before, data.wrench[:3], data.dt, data.after), "wrench 3"),
        (lambda: LinearRegression().fit(data[:0]), "at least one"),
        (lambda: LinearRegression().score(data), "call fit"),
        (lambda: LinearRegression("mars").fit(data), "mars"),  # type: ignore[arg-type]
        (lambda: Transitions.simulated(free, 5), "body.mass"),
        (lambda: Transitions.simulated(model("chair", "free"), 5, dt=-0.1), "dt = -0.1"),
        (lambda: data.with_noise(-1.0), "sd = -1"),
        (lambda: Transitions.recorded(CONFIGS / "nowhere"), "nowhere"),
        (lambda: trundle.objects.read(CONFIGS / "nothing.toml"), "nothing.toml"),
    ]:
        with pytest.raises(trundle.TrundleError) as refused:
            call()  # type: ignore[no-untyped-call]
        assert words in str(refused.value)
    broken = Transitions(data.before, data.wrench, data.dt, np.where(np.eye(5, 6) > 0, np.nan, data.after))
    with pytest.raises(trundle.TrundleError, match="transition 0: state after"):
        LocallyWeightedRegression().fit(broken)
