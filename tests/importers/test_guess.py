"""Guessed maps: a recording that is written with other names and units comes back through its guessed map."""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from numpy.typing import NDArray

import trundle
from trundle.importers import guess_map, read, write_map
from trundle.importers.guess import set_key
from trundle.importers.units import UNITS

Table = dict[str, NDArray[np.float64]]

METADATA: dict[str, Any] = {
    "object": {"footprint": [[-0.5, -0.4], [0.5, -0.4], [0.5, 0.4], [-0.5, 0.4]]},
    "wrench": {"frame": "sensor", "sign": "on_object", "raw": True, "precontact": [0.0, 0.3]},
}
PLANAR = (
    *(f"{body}_{part}" for body in ("object", "gripper") for part in ("x", "y", "theta")),
    *("force_x", "force_y", "torque_z"),
)
OBJECTS = ("object", "obj", "cart", "table", "Body", "mocap/table", "/mocap/desk/pose")
GRIPPERS = ("gripper", "hand", "tcp", "tool0", "EE", "end_effector", "/tf/flange")
JOINS = ("_", ".", "/", " ")
UNIT_FORMATS = ("{name}_{unit}", "{name} [{unit}]", "{name} ({unit})", "{name}[{unit}]")
WRENCHES = {
    "f": ("fx", "fy", "tz"),
    "F": ("Fx", "Fy", "Mz"),
    "force": ("force_x", "force_y", "torque_z"),
    "ros": ("wrench.force.x", "wrench.force.y", "wrench.torque.z"),
    "ft": ("ft_fx", "ft_fy", "ft_tz"),
    "tau": ("Fx", "Fy", "tau_z"),
}
TIMES = ("t", "time", "timestamp", "stamp", "header.stamp", "__time", "%time")
DECOYS = (
    *("battery", "vx", "vy", "omega", "cart_vel_x", "cmd_x", "target_yaw", "joint_1_pos", "temp_C", "seq"),
    *("roll_deg", "imu_ax", "status", "pose_covariance_x", "object_speed [m/s]"),
)
MIXED = (
    *("x", "y", "yaw", "fx", "fy", "tz", "t", "Fx", "a_x", "a_y", "a_yaw", "b_x", "b_y", "b_theta", "hand_x"),
    *("hand_y", "hand_yaw", "cart_x", "cart_y", "cart_yaw", "left_fx", "left_fy", "cmd_fx", "vx", "qw", "qx"),
    *("qy", "qz", "time_ms", "stamp", "mx", "rx", "theta_dot", "x_ref"),
)
SPELLED = {"N m": ("Nm", "N*m"), "N mm": ("Nmm", "mNm"), "rad": ("rad", "radians"), "deg": ("deg", "degrees")}


def recorded(seed: int, n: int = 60) -> Table:
    """Return a table of an episode at 100 Hz, in SI units."""
    rng = np.random.default_rng(seed)
    table = {"t": np.arange(n) / 100}
    for name in PLANAR:
        table[name] = np.cumsum(rng.uniform(0.001, 0.01, n)) * rng.choice([-1.0, 1.0]) + rng.uniform(-1, 1)
    return table


@st.composite
def layouts(draw: st.DrawFn) -> tuple[dict[str, str], dict[str, str], list[str]]:
    """Return the name and the unit of every column of a logger, and its other columns."""
    join, unit_format = draw(st.sampled_from(JOINS)), draw(st.sampled_from(UNIT_FORMATS))
    bodies = {"object": draw(st.sampled_from(OBJECTS)), "gripper": draw(st.sampled_from(GRIPPERS))}
    heading = draw(st.sampled_from(("theta", "yaw", "heading")))
    wrench = draw(st.sampled_from(sorted(WRENCHES)))
    with_units = draw(st.booleans())
    units = {
        "t": draw(st.sampled_from(sorted(UNITS["time"]))),
        "length": draw(st.sampled_from(sorted(UNITS["length"]))),
        "angle": draw(st.sampled_from(sorted(UNITS["angle"]))),
        "force": draw(st.sampled_from(sorted(UNITS["force"]))),
        "torque": draw(st.sampled_from(sorted(UNITS["torque"]))),
    }
    names, unit_of = {"t": draw(st.sampled_from(TIMES))}, {"t": units["t"]}
    for column in PLANAR:
        role, part = column.split("_")
        if role in bodies:
            names[column] = f"{bodies[role]}{join}{heading if part == 'theta' else part}"
            unit_of[column] = units["angle" if part == "theta" else "length"]
        else:
            names[column] = WRENCHES[wrench][("force_x", "force_y", "torque_z").index(column)]
            unit_of[column] = units[role]
    if with_units:
        for column, name in names.items():
            spelled = draw(st.sampled_from(SPELLED.get(unit_of[column], (unit_of[column],))))
            names[column] = unit_format.format(name=name, unit=spelled)
    else:
        unit_of = {column: "s" if column == "t" else si_unit(column) for column in names}
    decoys = draw(st.lists(st.sampled_from(DECOYS), unique=True, max_size=5))
    return names, unit_of, decoys


def dimension(column: str) -> str:
    role, _, part = column.partition("_")
    return "time" if column == "t" else role if role in UNITS else "angle" if part == "theta" else "length"


def si_unit(column: str) -> str:
    return next(iter(UNITS[dimension(column)]))


def write_log(
    path: Path, table: Table, names: dict[str, str], units: dict[str, str], decoys: list[str], sign: str = ","
) -> Path:
    """Write a table as a logger with other names and units would."""
    columns = {names[c]: v / UNITS[dimension(c)][units[c]] for c, v in table.items()}
    columns |= {name: np.linspace(5, 90, len(table["t"])) for name in decoys}
    rows = [
        sign.join(columns),
        *(sign.join(map(repr, map(float, row))) for row in zip(*columns.values(), strict=True)),
    ]
    path.write_text("\n".join(rows) + "\n", encoding="utf-8")
    return path


@settings(max_examples=60)
@given(layouts(), st.integers(0, 99), st.sampled_from([",", ";", "\t"]))
def test_a_recording_comes_back_through_its_guessed_map(
    layout: tuple[dict[str, str], dict[str, str], list[str]], seed: int, sign: str
) -> None:
    names, units, decoys = layout
    table = recorded(seed)
    with tempfile.TemporaryDirectory() as folder:
        file = write_log(Path(folder) / "log.csv", table, names, units, decoys, sign)
        guess = guess_map(file, {"recording": METADATA, "keep_repeats": True})
        assert guess.questions == []
        imported = read(file, "csv", guess.settings)
    found = imported.recording().episodes["episode_00"]
    assert set(found) == set(table)
    for name, values in table.items():
        actual = np.unwrap(found[name]) if name.endswith("theta") else found[name]
        turns = 2 * np.pi * np.round((actual[0] - values[0]) / (2 * np.pi)) if name.endswith("theta") else 0.0
        np.testing.assert_allclose(actual - turns, values, rtol=1e-9, atol=1e-9, err_msg=name)


@example(
    ["x", "y", "yaw", "fx", "fy", "tz", "t", "left_fx", "Fx"], 0
)  # a lone torque, three columns of force
@settings(max_examples=80)
@given(st.lists(st.sampled_from(MIXED), unique=True, min_size=2), st.integers(0, 9))
def test_a_guess_never_assigns_a_column_of_another_quantity(names: list[str], seed: int) -> None:
    """Whatever the columns are: velocities, commands and two candidates are never assigned."""
    values = np.random.default_rng(seed).uniform(-1, 1, (20, len(names)))
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "log.csv"
        np.savetxt(file, values, delimiter=",", header=",".join(names), comments="")
        guess = guess_map(file)
    assigned = {
        key: value["name"] for key, value in guess.settings["columns"].items() if isinstance(value, dict)
    }
    assert not set(assigned.values()) & {"vx", "cmd_fx", "theta_dot", "x_ref", "rx", "stamp", "t", "time_ms"}
    if len({"fx", "Fx", "left_fx"} & set(names)) > 1:
        assert "force_x" not in assigned
    for column, source in assigned.items():
        assert column[-2] != "_" or source.removesuffix("_ms")[-1] == column[-1]
    if {"cart_x", "cart_y", "cart_yaw"} <= set(names):
        assert assigned["object_x"] == "cart_x"
    elif {"a_x", "a_y", "a_yaw", "b_x", "b_y", "b_theta"} <= set(names):
        assert "object_x" not in assigned
        assert "columns.object_x" in [question.key for question in guess.questions]


def simple_log(folder: Path, **changed: Any) -> Path:
    """Write a log with columns that are certain; `changed` renames or scales them."""
    table = recorded(1)
    units = {column: si_unit(column) for column in table}
    names = {column: changed.get(column, column) for column in table}
    return write_log(folder / "log.csv", table, names, units, [])


def test_all_missing_keys_are_in_one_list(tmp_path: Path) -> None:
    guess = guess_map(simple_log(tmp_path))
    assert [question.key.removeprefix("recording.") for question in guess.questions] == [
        "object.footprint",
        *(f"wrench.{key}" for key in ("frame", "sign", "raw", "precontact")),
    ]
    assert "medium" in {one.confidence for one in guess.assignments}
    assert all(one.basis for one in guess.assignments)


@pytest.mark.parametrize(
    ("column", "scale", "choices"),
    [
        ("object_theta", 180 / np.pi * 10, "deg"),
        ("object_x", 1e3, "mm"),
        ("torque_z", 1e3, "N mm"),
        ("t", 1e2, "ms"),
    ],
)
def test_a_unit_that_the_values_contradict_is_a_question(
    tmp_path: Path, column: str, scale: float, choices: str
) -> None:
    table = recorded(1) | {column: recorded(1)[column] * scale}
    file = write_log(tmp_path / "log.csv", table, {c: c for c in table}, {c: si_unit(c) for c in table}, [])
    key = "time.unit" if column == "t" else f"columns.{column}.unit"
    asked = {question.key: question for question in guess_map(file).questions}
    assert asked[key].choices[0] == choices
    answered: dict[str, Any] = {}
    set_key(answered, key, choices)
    again = guess_map(file, answered)
    assert key not in [question.key for question in again.questions]


def test_two_bodies_are_ambiguous_until_one_column_is_given(tmp_path: Path) -> None:
    renamed = {f"{body}_{part}": f"{new}_{part}" for body, new in (("object", "a"), ("gripper", "b"))
               for part in ("x", "y", "theta")}  # fmt: skip
    file = simple_log(tmp_path, **renamed)
    asked = {question.key: question.choices for question in guess_map(file).questions}
    assert asked["columns.object_x"] == ("a_x", "b_x")
    given_bodies = {"columns": {"object_x": "b_x", "gripper_x": "a_x"}, "recording": METADATA}
    guess = guess_map(file, given_bodies)
    assert guess.is_complete and guess.source == file
    assert guess.settings["columns"]["object_theta"]["name"] == "b_theta"
    assert guess.settings["columns"]["gripper_y"]["name"] == "a_y"


def test_ros_names_seconds_and_nanoseconds_and_quaternions(tmp_path: Path) -> None:
    n, names = 50, ["header.stamp.secs", "header.stamp.nsecs"]
    t = np.arange(n) / 100
    columns = [1.7e9 + np.floor(t), np.round(1e9 * (t % 1))]
    half = np.linspace(0, 0.4, n)
    for body, offset in (("/table", 0.0), ("/tool0", 0.5)):
        names += [f"{body}/pose/position/{axis}" for axis in "xyz"]
        names += [f"{body}/pose/orientation/{axis}" for axis in "xyzw"]
        columns += [t + offset, -t, 0 * t, 0 * t, 0 * t, np.sin(half), np.cos(half)]
    names += ["/ft/wrench/force/x", "/ft/wrench/force/y", "/ft/wrench/torque/z"]
    columns += [np.sin(9 * t), np.cos(9 * t), t]
    file = tmp_path / "bag.csv"
    np.savetxt(file, np.column_stack(columns), "%.17g", ",", header=",".join(names), comments="")
    guess = guess_map(file, {"recording": METADATA, "keep_repeats": True})
    assert guess.questions == []
    table = read(file, "csv", guess.settings).recording().episodes["episode_00"]
    np.testing.assert_allclose(table["t"], t, atol=1e-6)
    np.testing.assert_allclose(table["object_theta"], 2 * half, atol=1e-12)
    np.testing.assert_allclose(table["gripper_x"], t + 0.5)


def test_a_position_and_a_force_are_a_rail(tmp_path: Path) -> None:
    file = tmp_path / "axis.csv"
    file.write_text("time_s,position_mm,force_N\n" + "".join(f"{k / 100},{k},{k % 7}\n" for k in range(50)))
    guess = guess_map(file, {"recording": {"wrench": {"sign": "on_object"}}})
    assert guess.questions == []
    recording = read(file, "csv", guess.settings).recording()
    np.testing.assert_allclose(recording.episodes["episode_00"]["object_x"], np.arange(50) / 1000)


def test_semicolons_decimal_commas_a_preamble_units_and_latin_1(tmp_path: Path) -> None:
    rows = ["Messung vom 3. März", "", "Zeit t;x;y;yaw;fx;fy;tz", "ms;mm;mm;°;N;N;Nmm"]
    rows += [f"{10 * k};{k},5;{k / 2:.1f};{k % 90};{k % 5},25;0,5;1000".replace(".", ",") for k in range(40)]
    file = tmp_path / "messung.csv"
    file.write_bytes(("\r\n".join(rows) + "\r\n").encode("latin-1"))
    guess = guess_map(file)
    assert guess.settings | {
        "encoding": "latin-1", "delimiter": ";", "decimal": ",", "skip_rows": 2, "unit_row": True,
    } == guess.settings  # fmt: skip
    units = {key: value["unit"] for key, value in guess.settings["columns"].items()}
    assert (units["object_x"], units["object_theta"], units["torque_z"]) == ("mm", "deg", "N mm")


def test_files_with_other_columns_are_refused(tmp_path: Path) -> None:
    (tmp_path / "a.csv").write_text("t,x\n0,1\n1,2\n")
    (tmp_path / "b.csv").write_text("t,fx\n0,1\n1,2\n")
    with pytest.raises(ValueError, match=r"b\.csv: its columns differ from those of a\.csv \(fx, x\)"):
        guess_map(tmp_path)


def test_a_written_map_is_completed_and_read(tmp_path: Path) -> None:
    file = simple_log(tmp_path)
    path = write_map(guess_map(file), tmp_path / "map.toml")
    text = path.read_text()
    assert text.count("# MISSING") == 5 and "# footprint = [[" in text
    answers = {"frame": '"sensor"', "sign": '"on_object"', "raw": "true"}
    for key, value in answers.items():
        line = next(line for line in text.splitlines() if line.startswith(f"# {key} ="))
        text = text.replace(line, f"{key} = {value}")
    path.write_text(text.replace("# footprint", "footprint").replace("# precontact", "precontact"))
    recording = read(file, "csv", path).recording()
    np.testing.assert_allclose(recording.episodes["episode_00"]["force_x"], recorded(1)["force_x"])
    assert trundle.check(recording) is not None
