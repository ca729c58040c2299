"""Recordings as mappings of names to episodes, episodes as mappings of columns, and streams."""

from __future__ import annotations

import pickle
from functools import cache

import numpy as np
import pytest

import trundle
from tests.record_prepare.table import OFFSET, Table, metadata, tables
from tests.record_prepare.table import recording as table_recording

TABLE = Table(episodes=3, metadata={"split": {"held_out": ["episode_02"]}})


@cache
def recording() -> trundle.Recording:
    return table_recording(TABLE)


def test_a_recording_is_a_mapping_of_episodes() -> None:
    names = ["episode_00", "episode_01", "episode_02"]
    assert len(recording()) == 3
    assert list(recording()) == recording().keys() == names
    assert "episode_01" in recording() and "episode_07" not in recording() and 3 not in recording()
    assert [episode.name for episode in recording().values()] == names
    assert dict(recording().items()) == recording().episodes == dict(recording())


def test_an_unknown_episode_is_an_error_that_lists_the_known_ones() -> None:
    for get in (recording().__getitem__, recording().frame):
        with pytest.raises(trundle.TrundleError, match=r"episode_07.*: episode_00, episode_01, episode_02"):
            get("episode_07")


def test_a_recording_of_its_own_episodes_is_equal() -> None:
    assert trundle.Recording(recording().metadata, recording().episodes) == recording()
    assert trundle.Recording(recording().metadata, recording()) == recording()
    fewer = {name: recording()[name] for name in ("episode_00", "episode_02")}
    assert list(trundle.Recording(recording().metadata, fewer)) == list(fewer)


def test_recordings_and_episodes_can_be_pickled() -> None:
    assert pickle.loads(pickle.dumps(recording())) == recording()
    episode = pickle.loads(pickle.dumps(recording()["episode_01"]))
    assert episode == recording()["episode_01"] != recording()["episode_00"]


def test_an_episode_knows_its_split_and_duration() -> None:
    assert [episode.held_out for episode in recording().values()] == [False, False, True]
    t = recording()["episode_00"]["t"]
    assert recording()["episode_00"].duration == t[-1] - t[0] > 1.0


def test_streams_have_their_own_times_and_no_empty_cells() -> None:
    episode = recording()["episode_00"]
    assert list(episode.streams) == ["object", "gripper", "wrench"]
    for stream in episode.streams.values():
        assert not np.isnan(stream.array).any()
        assert stream.array.shape == (len(stream.t), 3)
        first = next(iter(stream))
        np.testing.assert_array_equal(stream[first], episode[first][~np.isnan(episode[first])])
        np.testing.assert_array_equal(stream.t, episode["t"][~np.isnan(episode[first])])
    assert episode.object.rate == pytest.approx(1000 / 17)
    assert episode.wrench.rate == pytest.approx(100.0)
    assert episode.wrench.units == {"force_x": "N", "force_y": "N", "torque_z": "N·m"}


def test_a_missing_stream_is_empty() -> None:
    columns = {k: v for k, v in tables(TABLE)["episode_00"].items() if not k.startswith("gripper")}
    held = ~(np.isnan(columns["object_x"]) & np.isnan(columns["force_x"]))
    columns = {name: values[held] for name, values in columns.items()}
    described = metadata(TABLE) | {"split": {}, "wrench": {"frame": "object", "sign": "on_sensor"}}
    episode = trundle.Recording(described, {"episode_00": columns})["episode_00"]
    assert list(episode.streams) == ["object", "wrench"]
    assert (len(episode.gripper), len(episode.gripper.t)) == (0, 0)


def test_data_frames() -> None:
    episode = recording()["episode_00"]
    whole, poses = episode.frame(), episode.object.frame()
    assert list(whole.columns) == list(episode) and whole["object_x"].isna().any()
    assert (
        list(poses.columns) == ["t", "object_x", "object_y", "object_theta"] and not poses.isna().any().any()
    )
    assert recording().frame("episode_00").equals(whole)


def test_an_xarray_dataset_has_named_dimensions_and_units() -> None:
    episode = recording()["episode_02"]
    data = episode.to_xarray()
    assert dict(data.sizes) == {f"time_{name}": len(stream.t) for name, stream in episode.streams.items()}
    assert (data.torque_z.dims, data.torque_z.attrs["units"]) == (("time_wrench",), "N·m")
    assert data.time_object.attrs["units"] == "s"
    assert data.attrs == {"recording": recording().name, "episode": "episode_02", "held_out": 1}
    assert not any(np.isnan(data[name]).any() for name in data)
    assert episode.wrench.to_xarray().force_x.dims == ("time",)


def test_tared_streams_are_those_of_the_estimator() -> None:
    episode = recording()["episode_01"]
    tared, prepared = episode.tared(), trundle.prepare(recording())["episode_01"]
    assert list(tared) == ["object", "wrench", "reading"]
    np.testing.assert_array_equal(tared["wrench"].array, prepared["on_object"])
    np.testing.assert_array_equal(tared["reading"].array, prepared["reading"])
    np.testing.assert_array_equal(tared["object"].array, prepared["pose"])
    np.testing.assert_array_equal(tared["wrench"].t, prepared["wrench_t"])
    quiet = tared["reading"].t < TABLE.quiet - 0.05
    assert abs(episode.wrench["force_x"][: quiet.sum()].mean()) > 0.5 * abs(OFFSET[0])
    assert abs(tared["reading"]["force_x"][quiet].mean()) < 1e-9
