"""Design of a push for two indistinguishable models, the push, and the diagnosis after it."""

import json
from collections.abc import Mapping
from pathlib import Path

import pytest
import tomli_w

import trundle
from trundle.cli import main
from trundle.design import Design

CORNERS = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4], [-0.6, 0.4]]
DRAG = {"kind": "support_drag", "mu": 25.0, "spread": 1.0}
SLOPE = {"kind": "floor_slope", "accel_x": 0.03, "accel_y": -0.02}
BODY = {"footprint": CORNERS, "mass": 22.0}


def push(force: float, *shares: tuple[float, float]) -> dict[str, object]:
    """Return a push at the middle of the short side along the table's x, from a fixed pose."""
    knots = [[0.0, 0.0, 0.0, 0.0], *([t, force * share, 0.0, 0.0] for t, share in shares)]
    return {"grasp": [0.57, 0.0, 0.0], "drive": "force", "knots": knots}


ALIKE = [
    push(12.0, (0.2, 1.0), (1.0, 1.0), (1.2, -1.0), (3.0, -1.0), (3.2, 1.0), (4.0, 0.0)),
    push(20.0, (0.1, 1.0), (0.5, 1.0), (0.6, -1.0), (1.4, -1.0), (1.5, 0.5), (4.0, 0.0)),
    push(9.0, (0.2, 1.0), (2.0, 1.0), (2.2, 0.0), (4.0, 0.0)),
    push(
        15.0, (0.1, 1.0), (0.4, 1.0), (0.5, 0.0), (1.5, 0.0), (1.6, -1.0), (2.1, -1.0), (2.2, 0.0), (4.0, 0.0)
    ),
]


def simulated(folder: Path, pushes: list[dict[str, object]], seed: int = 3) -> trundle.Recording:
    """Record pushes of a table on a sloping floor with `trundle.simulate`."""
    folder.mkdir(exist_ok=True)
    scenario = {
        "format": "trundle-scenario/1",
        "name": "table",
        "object": "object.toml",
        "effect": [DRAG, SLOPE],
        "push": pushes,
    }
    described = {"format": "trundle-object/1", "name": "table", "body": BODY}
    (folder / "object.toml").write_text(tomli_w.dumps(described))
    (folder / "scenario.toml").write_text(tomli_w.dumps(scenario))
    return trundle.simulate(folder / "scenario.toml", seed=seed)


def model(folder: Path, *effects: Mapping[str, object], body: bool = True, name: str = "") -> Path:
    """Write a model file."""
    path = folder / f"{name or effects[-1]['kind']}.toml"
    tables = {"format": "trundle-model/1", "body": BODY if body else {}, "effect": list(effects)}
    path.write_text(tomli_w.dumps(tables))
    return path


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("design")


@pytest.fixture(scope="module")
def competing_models(place: Path) -> tuple[Path, Path]:
    free = {"kind": "support_drag"}
    slope, bias = (
        model(place, free, {"kind": kind}, body=False, name=f"free_{kind}")
        for kind in ("floor_slope", "force_bias")
    )
    return slope, bias


@pytest.fixture(scope="module")
def tied(place: Path) -> trundle.Recording:
    recording = simulated(place / "tied", ALIKE)
    recording.write(place / "recording")
    return recording


@pytest.fixture(scope="module")
def found(competing_models: tuple[Path, Path], tied: trundle.Recording) -> Design:
    return trundle.design(*competing_models, recording=tied)


def preference(recording: trundle.Recording, competing_models: tuple[Path, Path]) -> float:
    """Return the log evidence ratio of slope and offset, nats."""
    slope, bias = (
        trundle.fit(recording, model_path).summary["log_evidence"] for model_path in competing_models
    )
    return float(slope - bias)


def test_the_designed_push_distinguishes_the_models(
    place: Path, competing_models: tuple[Path, Path], tied: trundle.Recording, found: Design
) -> None:
    assert found.models == ("floor_slope", "force_bias")
    assert abs(found.recorded) < 2.0
    assert abs(preference(tied, competing_models)) < 5.0
    assert found.sure > 0.95 and found.repeats == 1
    scenario, described = found.scenario()
    assert "accel_x" in scenario and "footprint" in described
    after = simulated(place / "after", [*ALIKE, found.pushes[0].table()])
    assert preference(after, competing_models) > 0.3 * found.separation[0] > 30.0


def test_the_designed_push_keeps_its_limits(found: Design) -> None:
    best = found.pushes[0]
    assert abs(best.start[2]) > 0.5 or abs(best.grasp[1]) > 0.3
    # The recorded pushes: 20 N with noise, for 4 s.
    assert abs(best.knots[:, 1]).max() <= 22.0 and abs(best.knots[:, 3]).max() <= 8.0
    assert best.knots[-1, 0] == pytest.approx(best.duration)
    assert best.duration == pytest.approx(4.0, abs=0.05)


def test_tighter_limits_separate_less(
    competing_models: tuple[Path, Path], tied: trundle.Recording, found: Design
) -> None:
    gentle = trundle.design(
        *competing_models, recording=tied, force=6.0, torque=1.0, duration=2.0, distance=0.2
    )
    assert 0.0 < sum(gentle.separation) < 0.5 * sum(found.separation)
    assert abs(gentle.pushes[0].knots[:, 1]).max() <= 6.0 and gentle.pushes[0].duration == 2.0


def test_the_same_input_gives_the_same_bytes(
    competing_models: tuple[Path, Path], tied: trundle.Recording, found: Design
) -> None:
    assert trundle.design(*competing_models, recording=tied).to_json() == found.to_json()


def test_the_written_scenario_can_be_simulated(place: Path, capsys: pytest.CaptureFixture[str]) -> None:
    offset = {"kind": "force_bias", "force_x": 0.7, "force_y": -0.4, "torque_z": 0.0}
    first, second = model(place, DRAG, SLOPE), model(place, DRAG, offset)
    out = place / "written"
    assert main(["design", str(first), str(second), "--pushes", "2", "--out", str(out), "--quiet"]) == 0
    answer = json.loads((out / "design.json").read_text())
    spoken = capsys.readouterr().out
    assert answer["sentence"] in spoken and "push 2:" in spoken
    assert answer["pushes"][1]["cumulative"] > answer["pushes"][0]["cumulative"]
    assert main(["simulate", str(out / "scenario.toml"), "--out", str(place / "made")]) == 0
    assert len(trundle.read(place / "made").episodes) == 2


def test_the_object_may_come_from_another_file(place: Path) -> None:
    offset = {"kind": "force_bias", "force_x": 0.7, "force_y": -0.4, "torque_z": 0.0}
    first = model(place, DRAG, SLOPE, body=False, name="bare_slope")
    second = model(place, DRAG, offset, body=False, name="bare_bias")
    with pytest.raises(trundle.TrundleError, match="footprint"):
        trundle.design(first, second)
    shaped = trundle.design(first, second, object=model(place, DRAG, name="shape"))
    assert shaped.pushes and "22" in shaped.scenario()[1]


def test_identical_models_have_no_discriminating_push(place: Path) -> None:
    same = model(place, DRAG, SLOPE)
    nothing = trundle.design(same, same)
    assert nothing.pushes == () and nothing.repeats is None
    assert "No push" in nothing.sentence
    with pytest.raises(trundle.TrundleError, match="no push"):
        nothing.scenario()


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ({"force": -1.0}, "force = -1"),
        ({"noise": (0.0, 1e-3, 0.4, 0.05)}, "standard deviation"),
        ({"pushes": 0}, "at least one"),
    ],
)
def test_invalid_arguments_are_refused(place: Path, arguments: dict[str, object], words: str) -> None:
    same = model(place, DRAG, SLOPE)
    with pytest.raises(trundle.TrundleError, match=words):
        trundle.design(same, same, **arguments)  # type: ignore[call-overload]


def test_a_free_value_without_a_recording_is_refused(
    competing_models: tuple[Path, Path], place: Path
) -> None:
    with pytest.raises(trundle.TrundleError, match="has no value"):
        trundle.design(*competing_models, object=model(place, DRAG, name="shape"))
