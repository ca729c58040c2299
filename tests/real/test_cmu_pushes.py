"""CMU pushes: viscous and dry friction compared, under a body with known feet and weight."""

from __future__ import annotations

import numpy as np
import pytest

import trundle
from examples.real_recordings import compare_under_body, wrench_r2

SETS = [
    "hardboard__10_130_10_10_10_130",
    "hardboard__10_90_10_10_30_130",
    "hardboard__30_63.33_43.33_30_43.33_63.33",
    "hardboard__30_90_30_30_30_90",
    "hardboard__patch",
]


@pytest.fixture(scope="module")
def compared(pushes: dict[str, trundle.Recording]) -> dict[str, tuple[float, float, float]]:
    return {name: compare_under_body(recording) for name, recording in pushes.items()}


def test_dry_friction_explains_held_out_pushes_better(
    compared: dict[str, tuple[float, float, float]],
) -> None:
    """An independent estimate over ten such sets: 0.864 for viscous, 0.913 for dry friction on average."""
    assert list(compared) == SETS
    for name, (viscous, dry, _) in compared.items():
        assert dry > viscous + 0.01, name
    viscous, dry, _ = np.mean(list(compared.values()), axis=0)
    assert viscous == pytest.approx(0.852, abs=0.02)
    assert dry == pytest.approx(0.926, abs=0.02)


def test_the_friction_agrees_with_the_pull_test(
    compared: dict[str, tuple[float, float, float]],
) -> None:
    """They pulled the object with 4.2 N."""
    for name, (_, _, friction) in compared.items():
        assert friction == pytest.approx(4.2, rel=0.12), name


@pytest.mark.parametrize("name", SETS)
def test_the_diagnosis_names_dry_friction_under_the_body(
    pushes: dict[str, trundle.Recording], name: str
) -> None:
    found = trundle.diagnose(pushes[name])
    assert found.verdict == "explained"
    assert found.missing == ["coulomb_friction"]
    effect = found.answer["missing"][0]
    assert "under the whole body" in effect["statement"]
    assert effect["where"] is None
    assert effect["explains"] > 0.1
    corners = pushes[name].metadata["object"]["footprint"]
    assert wrench_r2(found.series, corners, "after") > wrench_r2(found.series, corners) + 0.02
    # The mass was weighed; slow pushes do not identify it.
    assert "mass" not in found.answer["nominal"]["after"]
    for figures in found.answer["fit"]["held_out"].values():
        given = {key for key, value in figures.items() if value is not None}
        assert given == {"force_rmse", "torque_rmse"}
