"""The online estimate agrees with a fit of all pushes, for complete pushes and chunks."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trundle

SCENARIO = """
format = "trundle-scenario/1"
name = "table"
object = "{table}"
held_out = 0
[[effect]]
kind = "viscous_wheel"
x = -0.5
y = -0.3
angle = 0.2
mu_x = 15.0
mu_y = 180.0
[random]
count = 4
duration = 4.0
speed = 0.3
spin = 0.5
"""


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> trundle.Recording:
    folder = tmp_path_factory.mktemp("push")
    table = Path(__file__).parents[2] / "configs" / "objects" / "office_table.toml"
    (folder / "push.toml").write_text(SCENARIO.format(table=table), encoding="utf-8")
    return trundle.simulate(folder / "push.toml", seed=2)


def numbers(rows: Sequence[Mapping[str, Any]]) -> dict[str, tuple[float, float]]:
    return {row["name"]: (row["mean"], row["sd"]) for row in rows if row["identifiable"]}


def test_online_updates_agree_with_a_fit_of_all_pushes(recording: trundle.Recording) -> None:
    online = trundle.Online(recording.metadata)
    assert online.estimate() == [] and online.model is None
    for name in recording.episodes:
        online.update(recording.episodes[name])
    assert online.pushes == 4 and online.hypotheses == 1
    batch = numbers(trundle.fit(recording).summary["parameters"])
    ours = numbers(online.estimate())
    assert ours.keys() == batch.keys() and len(ours) == 6
    for name, (mean, sd) in batch.items():
        assert abs(ours[name][0] - mean) < sd, name
        assert ours[name][1] == pytest.approx(sd, rel=0.25), name
    assert online.model is not None
    assert {p["name"] for p in online.model.parameters} >= {"body.mass"}


def test_chunks_give_the_same_estimate_as_the_push(recording: trundle.Recording) -> None:
    whole, chunked = (trundle.Online(recording.metadata) for _ in range(2))
    for name in list(recording.episodes)[:2]:
        columns = recording.episodes[name]
        whole.update(columns)
        n = len(columns["t"])
        for rows in np.array_split(np.arange(n), 5):
            chunked.extend({key: column[rows] for key, column in columns.items()})
        assert chunked.waiting is None
        chunked.update()
    for name, (mean, sd) in numbers(whole.estimate()).items():
        assert abs(numbers(chunked.estimate())[name][0] - mean) < 0.5 * sd, name


def test_a_refused_push_is_discarded(recording: trundle.Recording) -> None:
    online = trundle.Online(recording.metadata)
    columns = next(iter(recording.episodes.values()))
    few = {key: column[:8] for key, column in columns.items()}
    online.extend(few)
    assert online.waiting is not None
    with pytest.raises(trundle.TrundleError):
        online.update()
    assert online.waiting is None
    online.extend(few)
    with pytest.raises(trundle.TrundleError, match="the columns of the first chunk are"):
        online.extend({key: column for key, column in few.items() if key != "torque_z"})
    with pytest.raises(trundle.TrundleError, match="lists of one length"):
        online.extend({**few, "t": few["t"][:3]})
    with pytest.raises(trundle.TrundleError, match="lists of one length"):
        online.extend({key: column[0] for key, column in few.items()})
    with pytest.raises(trundle.TrundleError):
        online.update({"t": [0.0]})
    online.extend({key: column[8:] for key, column in columns.items()})
    online.update()
    assert online.pushes == 1


@pytest.mark.parametrize("before", [0, 1])
def test_an_invalid_push_does_not_change_the_estimate(recording: trundle.Recording, before: int) -> None:
    online = trundle.Online(recording.metadata)
    first, columns = list(recording.episodes.values())[:2]
    for push in [first][:before]:
        online.update(push)
    known, model = online.estimate(), online.model and online.model.to_toml()
    half = {
        key: column[: len(column) // 2] * (3.0 if "force" in key else 1.0) for key, column in columns.items()
    }
    online.extend(half)
    assert online.waiting is None and online.estimate() != known
    online.extend({**half, "t": half["t"] - 1.0})
    with pytest.raises(trundle.TrundleError):
        online.update()
    assert online.estimate() == known and online.pushes == before
    assert (online.model and online.model.to_toml()) == model
    online.update(columns)
    assert online.pushes == before + 1


def test_unusable_input_is_refused_without_effect(recording: trundle.Recording) -> None:
    online = trundle.Online(recording.metadata)
    with pytest.raises(trundle.TrundleError, match="no push"):
        online.update()
    with pytest.raises(trundle.TrundleError):
        online.update({"t": [0.0]})
    assert online.pushes == 0
    with pytest.raises(trundle.TrundleError, match="at least one"):
        trundle.Online(recording.metadata, starts=0)
