"""`trundle.Model`: reading, writing, rolling out."""

from pathlib import Path

import numpy as np
import pytest
from numpy.typing import ArrayLike

import trundle

TABLE = """
format = "trundle-model/1"
[body]
footprint = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]
mass = 20.0
[[effect]]
kind = "viscous_wheel"
x = -0.5
y = -0.3
angle = 0.2
mu_x = 15.0
mu_y = 180.0
"""


def test_a_model_is_restored_from_its_file(tmp_path: Path) -> None:
    model = trundle.Model.from_toml(TABLE)
    model.write(tmp_path / "model.toml")
    again = trundle.Model.read(tmp_path / "model.toml")
    assert again.parameters == model.parameters
    assert [entry.name for entry in tmp_path.iterdir()] == ["model.toml"]


def test_a_failed_write_changes_nothing(tmp_path: Path) -> None:
    (tmp_path / "model.toml").mkdir()
    with pytest.raises(trundle.TrundleError, match=r"model\.toml"):
        trundle.Model.from_toml(TABLE).write(tmp_path / "model.toml")
    assert [entry.name for entry in tmp_path.iterdir()] == ["model.toml"]


def test_parameters_have_names_units_bounds_and_values() -> None:
    model = trundle.Model.from_toml(TABLE.replace("mu_x = 15.0\n", ""))
    values = {p["name"]: p["value"] for p in model.parameters}
    assert values["body.mass"] == 20.0
    assert values["viscous_wheel.mu_x"] is None
    x = next(p for p in model.parameters if p["name"] == "viscous_wheel.x")
    assert (x["unit"], x["lower"], x["upper"]) == ("m", -0.6, 0.6)


def test_a_free_body_follows_newtons_law() -> None:
    model = trundle.Model.from_toml(TABLE.split("[[effect]]")[0])
    t = np.linspace(3.0, 5.0, 21)
    wrench = np.column_stack([10.0 * (t - 3.0), np.zeros_like(t), np.zeros_like(t)])
    poses, twists = model.rollout([1.0, 2.0, 0.0], [0.1, 0.0, 0.0], t, wrench)
    s = t - 3.0
    np.testing.assert_allclose(twists[:, 0], 0.1 + 0.25 * s**2, atol=1e-12)
    np.testing.assert_allclose(poses[:, 0], 1.0 + 0.1 * s + 0.25 * s**3 / 3, atol=2e-6)
    np.testing.assert_array_equal(poses[:, 1:], np.tile([2.0, 0.0], (21, 1)))


def test_some_effects_start_at_contact() -> None:
    text = TABLE.split("[[effect]]")[0] + '[[effect]]\nkind = "floor_slope"\naccel_x = 0.5\naccel_y = 0.0\n'
    t = np.linspace(0.0, 2.0, 201)
    model = trundle.Model.from_toml(text)
    poses, twists = model.rollout(np.zeros(3), np.zeros(3), t, np.zeros((201, 3)), contact=1.0)
    assert not poses[:100].any()
    assert twists[-1, 0] == pytest.approx(0.5, abs=2e-3)


@pytest.mark.parametrize(
    ("t", "wrench", "words"),
    [
        ([0.0, 1.0], np.zeros((3, 3)), "2 values and wrench 3 rows"),
        ([0.0, 1.0, 1.0], np.zeros((3, 3)), r"t\[2\] = 1"),
        ([0.0, np.nan], np.zeros((2, 3)), r"t\[1\] = NaN"),
        ([0.0, 1.0], [[0, 0, 0], [0, np.inf, 0]], r"wrench\[1\]"),
        ([0.0, 1.0], np.zeros((2, 6)), r"shape \(n, 3\)"),
        ([], np.zeros((0, 3)), "0 values"),
    ],
)
def test_unusable_samples_are_named(t: list[float], wrench: ArrayLike, words: str) -> None:
    with pytest.raises(trundle.TrundleError, match=words):
        trundle.Model.from_toml(TABLE).rollout([0, 0, 0], [0, 0, 0], t, wrench)


def test_a_free_parameter_cannot_be_rolled_out() -> None:
    model = trundle.Model.from_toml(TABLE.replace("mu_y = 180.0\n", ""))
    with pytest.raises(trundle.TrundleError, match=r"viscous_wheel\.mu_y has no value"):
        model.rollout([0, 0, 0], [0, 0, 0], [0, 1], np.zeros((2, 3)))


def test_unusable_files_are_named(tmp_path: Path) -> None:
    with pytest.raises(trundle.TrundleError, match=r"none\.toml"):
        trundle.Model.read(tmp_path / "none.toml")
    path = tmp_path / "bad.toml"
    path.write_text(TABLE.replace("mu_x", "mux"))
    with pytest.raises(trundle.TrundleError, match=r"bad\.toml.*mux.*mu_x"):
        trundle.Model.read(path)
