"""Streams: stale reads, repeated time stamps and the joined table; and rotations of poses."""

from __future__ import annotations

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from trundle.importers.rotations import from_axes, from_heading, from_rpy, heading, product, rotate, tilt
from trundle.importers.streams import Stream, drop_stale, join

times = st.lists(st.integers(0, 1000), min_size=1, max_size=40, unique=True).map(
    lambda t: np.array(sorted(t)) / 100
)
angles = st.floats(-3.1, 3.1)


def test_stale_reads_are_dropped_and_rests_kept() -> None:
    """At 100 Hz every value is read twice during motion; then follows a rest of 0.2 s."""
    x = np.concatenate([np.repeat(np.arange(5.0), 2), np.full(20, 9.0)])
    stream = Stream(["x", "y"], np.arange(30) / 100, np.column_stack([x, x]))
    kept, count = drop_stale(stream)
    assert count == 5
    np.testing.assert_array_equal(kept.values[:5, 0], np.arange(5.0))
    assert len(kept.t) == 25


def test_the_first_sample_of_a_time_stamp_is_kept() -> None:
    stream = Stream(["x"], np.array([0.2, 0.1, 0.2]), np.array([[1.0], [2.0], [3.0]]))
    kept, count = stream.ordered()
    np.testing.assert_array_equal(kept.t, [0.1, 0.2])
    np.testing.assert_array_equal(kept.values[:, 0], [2.0, 1.0])
    assert count == 1


@given(times, times)
def test_the_joined_table_contains_every_sample_once(one: np.ndarray, other: np.ndarray) -> None:
    streams = [
        Stream(["a", "b"], one, np.column_stack([one, -one])),
        Stream(["c"], other, other[:, None] ** 2),
    ]
    table = join(streams)
    assert np.all(np.diff(table["t"]) > 0)
    assert np.all(np.isfinite(table["a"]) | np.isfinite(table["c"]))
    for stream in streams:
        for name, values in zip(stream.names, stream.values.T, strict=True):
            there = np.isfinite(table[name])
            np.testing.assert_array_equal(table["t"][there], stream.t)
            np.testing.assert_array_equal(table[name][there], values)


@given(angles, angles, angles, angles)
def test_rotations_agree_with_scipy(roll: float, pitch: float, yaw: float, turn: float) -> None:
    a = from_rpy(np.array([roll, pitch, yaw]))
    b = from_heading(np.array([turn]))[0]
    one = Rotation.from_euler("xyz", [roll, pitch, yaw])
    other = Rotation.from_euler("z", turn)
    v = np.array([0.3, -1.0, 2.0])
    np.testing.assert_allclose(rotate(a, v), one.apply(v), atol=1e-12)
    np.testing.assert_allclose(rotate(product(a, b), v), (one * other).apply(v), atol=1e-12)
    np.testing.assert_allclose(heading(b), turn, atol=1e-12)
    np.testing.assert_allclose(np.cos(tilt(a)), one.as_matrix()[2, 2], atol=1e-12)
    x, y, _ = one.as_matrix()
    np.testing.assert_allclose(rotate(from_axes(x, y), v), one.apply(v), atol=1e-12)
