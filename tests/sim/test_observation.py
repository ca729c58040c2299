"""`trundle.envs.Observation`: each named field agrees with the state of the simulator."""

from __future__ import annotations

import pickle
from typing import Any

import gymnasium
import numpy as np
import pytest

import trundle
from trundle.envs import Observation, PushAround, PushDoor, PushPath, PushPose
from trundle.envs.observation import COMMON_ENTRIES, PlanarPose

SHARED = (
    "position",
    "direction",
    "velocity",
    "spin",
    "goal_position",
    "goal_direction",
    "force",
    "torque",
    "grasp",
)
"""Fields that together contain each shared entry once, in order."""
PUSH = np.array([0.4, -0.3, 0.2], dtype=np.float32)


def rotation(angle: float) -> Any:
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


def state(env: Any) -> dict[str, Any]:
    """Return the true state: poses of object, goal and gripper, wrench, obstacles and path."""
    seen: dict[str, Any] = env.unwrapped._native.view()
    return seen


def test_shared_fields_contain_each_shared_entry_once_and_in_order() -> None:
    fields = Observation(np.arange(16.0))
    assert np.concatenate([np.atleast_1d(getattr(fields, name)) for name in SHARED]).tolist() == [*range(16)]
    assert len(PushPose()._native.bounds) == COMMON_ENTRIES


@pytest.mark.parametrize("task", [PushPose, PushAround])
def test_shared_fields_are_the_state_of_the_simulator(task: type[PushPose]) -> None:
    env = task(hidden="locked", noise=0.0, step=0.001, substeps=20)
    env.reset(seed=3, options={"grasp": (-0.6, 0.25)})
    for _ in range(6):
        before = state(env)
        observation, *_, info = env.step(PUSH)
    now, fields = state(env), Observation(observation)
    x, y, angle = now["object"]
    np.testing.assert_allclose(fields.position, (x, y))
    np.testing.assert_allclose(np.exp(1j * fields.heading), np.exp(1j * angle))
    np.testing.assert_allclose(fields.direction, (np.cos(angle), np.sin(angle)))
    np.testing.assert_allclose(fields.pose, (*fields.position, fields.heading))
    np.testing.assert_array_equal(fields.pose_vector, (*fields.position, *fields.direction))
    # The velocity is that at the end of an action, the difference quotient that in its middle.
    quotient = (np.array(now["object"]) - before["object"]) / env.control
    np.testing.assert_allclose(fields.twist, quotient, rtol=0.25)
    np.testing.assert_array_equal(fields.twist, (*fields.velocity, fields.spin))
    assert len({round(abs(entry), 3) for entry in fields.twist}) == 3, "the entries must differ"
    np.testing.assert_allclose(fields.goal_position, now["goal"][:2])
    np.testing.assert_allclose(np.exp(1j * fields.goal_heading), np.exp(1j * now["goal"][2]))
    np.testing.assert_allclose(fields.goal_pose, (*fields.goal_position, fields.goal_heading))
    np.testing.assert_allclose(fields.wrench, PUSH * env.ACTION_SCALE, rtol=1e-6)
    np.testing.assert_allclose(fields.wrench, (*fields.force, fields.torque))
    np.testing.assert_allclose(fields.grasp, (-0.6, 0.25))
    np.testing.assert_allclose(fields.position + rotation(angle) @ fields.grasp, now["gripper"][:2])
    assert np.hypot(*(fields.goal_position - fields.position)) == pytest.approx(info["distance"])
    turn = np.exp(1j * (fields.heading - fields.goal_heading))
    assert abs(np.angle(turn)) == pytest.approx(abs(info["heading_error"]))


def test_bounds_are_those_of_the_observation_space() -> None:
    bounds = Observation(PushPose().observation_space.high)  # type: ignore[attr-defined]
    expected: dict[str, float] = {"position": 3, "direction": 1, "velocity": 4, "spin": 7, "goal_position": 3}
    expected |= {"goal_direction": 1, "force": 120, "torque": 43, "grasp": 1.5}
    for name, bound in expected.items():
        assert np.all(getattr(bounds, name) == bound), name


def test_half_size_is_half_the_bounding_box() -> None:
    env = PushDoor(object=["bed", "bookcase"])
    for seed in range(4):
        half = Observation(env.reset(seed=seed)[0]).half_size
        corners = np.concatenate([np.array(part) for part in state(env)["fixtures"]])
        np.testing.assert_allclose(half, np.ptp(corners, axis=0) / 2)


@pytest.mark.parametrize("object_name", ["office_table", "household"])
def test_path_points_are_ahead_on_the_path(object_name: str) -> None:
    env = PushPath(object=object_name, noise=0.0)
    fields = Observation(env.reset(seed=1)[0])
    path = np.array(state(env)["path"])
    length = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(path, axis=0).T))])
    for ahead, point in zip((0.3, 0.6, 0.9), (fields.goal_position, *fields.path_points), strict=True):
        expected = [np.interp(ahead, length, column) for column in path.T]
        np.testing.assert_allclose(point, expected, atol=5e-3)


@pytest.mark.parametrize("object_name", ["office_table", "household"])
def test_box_fields_describe_the_obstacle(object_name: str) -> None:
    env = PushAround(object=object_name)
    for seed in range(3):
        observation, _ = env.reset(seed=seed)
        fields, (obstacle,) = Observation(observation), state(env)["obstacles"]
        (cos, sin), corners = fields.box_direction, np.array(obstacle) - fields.box_position
        along, across = corners @ (cos, sin), corners @ (-sin, cos)
        np.testing.assert_allclose(np.abs(along), fields.box_half_size[0])
        np.testing.assert_allclose(np.abs(across), fields.box_half_size[1])
        (seen,) = env.seen_obstacles(observation)
        np.testing.assert_allclose(sorted(seen), sorted(map(tuple, obstacle)))


@pytest.mark.parametrize("object_name", ["office_table", "household"])
def test_door_fields_describe_the_opening(object_name: str) -> None:
    env = PushDoor(object=object_name)
    for seed in range(3):
        observation, _ = env.reset(seed=seed)
        fields, walls = Observation(observation), state(env)["obstacles"]
        cos, sin = fields.door_direction
        across = [(np.array(wall) - fields.door_position) @ (-sin, cos) for wall in walls]
        assert sorted(np.abs(each).min() for each in across) == pytest.approx([fields.door_width / 2] * 2)
        along = [(np.array(wall) - fields.door_position) @ (cos, sin) for wall in walls]
        np.testing.assert_allclose(np.abs(along), 0.05, err_msg="the wall is 10 cm thick")
        assert len(env.seen_obstacles(observation)) == len(walls) == 2


def test_fields_of_a_batch_are_those_of_each_row() -> None:
    envs = gymnasium.make_vec("trundle/PushPath-v0", num_envs=3)
    rows, _ = envs.reset(seed=0)
    batch = Observation(rows)
    for name in (*SHARED, "heading", "pose", "goal_pose", "twist", "wrench", "path_points"):
        field = getattr(batch, name)
        for row, value in zip(rows, field, strict=True):
            np.testing.assert_array_equal(value, getattr(Observation(row), name))
    assert batch.path_points.shape == (3, 2, 2) and batch.heading.shape == batch.spin.shape == (3,)
    assert batch.without_goal().shape == (3, 16)
    np.testing.assert_array_equal(PlanarPose(batch.goal_vector).heading, batch.goal_heading)


def test_assignment_to_a_field_changes_the_vector() -> None:
    fields = Observation(np.zeros((2, 20)))
    fields.goal_position[:] = (1.0, 2.0)
    fields.path_points[:, 1] = (3.0, 4.0)
    assert np.flatnonzero(fields.vector[0]).tolist() == [7, 8, 18, 19]
    assert isinstance(Observation(np.zeros(16)).spin, float)


def test_a_copy_by_pickle_is_equal() -> None:
    fields = Observation(np.arange(16.0))
    np.testing.assert_array_equal(pickle.loads(pickle.dumps(fields)).vector, fields.vector)


@pytest.mark.parametrize("shape", [(), (15,), (4, 3)])
def test_vectors_that_are_too_short_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(trundle.TrundleError, match="at least 16 entries"):
        Observation(np.zeros(shape))
