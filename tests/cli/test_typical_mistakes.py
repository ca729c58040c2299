"""Typical mistakes of a first-time user: messages name the place and the remedy, and nothing is written."""

from __future__ import annotations

import os
import re
import signal
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trundle
from tests.command import COMMAND, at_work, interruptible
from trundle.cli import main
from trundle.importers import guess_map, read

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

HEADER = "t,object_x,object_y,object_theta,force_x,force_y,torque_z"
METADATA: dict[str, Any] = {
    "format": "trundle-recording/1",
    "name": "table",
    "object": {"footprint": [[-0.5, -0.4], [0.5, -0.4], [0.5, 0.4], [-0.5, 0.4]]},
    "wrench": {"frame": "object", "sign": "on_object", "raw": False},
}


def pushed(n: int = 400, speed: float = 0.1) -> dict[str, Any]:
    """Return a table of an episode: a straight push that is slowed by drag."""
    t = np.arange(n) / 100
    along = speed * (t + np.sin(3 * t) / 6)
    zero, drag = 0 * t, 30.0 * speed * (1 + np.cos(3 * t) / 2)
    return {
        "t": t, "object_x": along, "object_y": zero, "object_theta": 0.3 * np.sin(t),
        "force_x": drag, "force_y": zero, "torque_z": np.cos(t),
    }  # fmt: skip


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return a folder with a recording, a free model, logs and a map, which is also the working folder."""
    trundle.Recording(METADATA, {f"episode_{k:02d}": pushed() for k in range(2)}).write(tmp_path / "rec")
    trundle.Recording(METADATA, {"episode_00": pushed()}).write(tmp_path / "my rec")
    (tmp_path / "model.toml").write_text('format = "trundle-model/1"\n[[effect]]\nkind = "viscous_wheel"\n')
    (tmp_path / "log.csv").write_text(f"{HEADER}\n0,0,0,0,1,0,0\n0.01,0,0,0,1,0,0\n0.02,0.1,0,0,1,0,0\n")
    (tmp_path / "empty.csv").write_text("")
    (tmp_path / "cut.csv").write_text(f"{HEADER}\n0,0,0,0,1,0,0\n0.01,0,0\n")
    (tmp_path / "comma.csv").write_text(f"{HEADER.replace(',', ';')}\n0,0;0,1;0;0;1;0;0\n0,1;0,2;0;0;1;0;0\n")
    (tmp_path / "latin.csv").write_bytes(f"# März\n{HEADER}\n0,0,0,0,1,0,0\n".encode("latin-1"))
    nan = "0,nan,nan,nan,1,0,0\n0.01,nan,nan,nan,1,0,0\n"
    (tmp_path / "nan.csv").write_text(f"{HEADER}\n{nan}")
    columns = ", ".join(f'{name} = "{name}"' for name in HEADER.split(",")[1:])
    (tmp_path / "map.toml").write_text(f'time = "t"\ncolumns = {{{columns}}}\n')
    (tmp_path / "photo.csv").write_bytes(b"\x89PNG\0\0\0")
    monkeypatch.chdir(tmp_path)
    return tmp_path


CASES = {
    "wrong path": ("check rek", ["rek: no such file or folder", "did you mean rec?"]),
    "path before the verb": ("rec diagnose", ["the verb comes first: `trundle diagnose rec`"]),
    "misspelt verb": ("diagnos rec", ["unknown verb 'diagnos'", "did you mean 'diagnose'"]),
    "misspelt option": ("fit rec --modle model.toml", ["'--modle'; did you mean '--model'?"]),
    "missing quotes": ("check my rec", ["unexpected argument 'rec'", "quote names that contain spaces"]),
    "missing quotes in a list": ("fit my rec", ["my: no such file or folder; quote the name: 'my rec'"]),
    "file instead of folder": ("check rec/recording.toml", ["give the folder that contains it: rec"]),
    "log instead of recording": ("check log.csv", ["`trundle import log.csv --guess --out DIR`"]),
    "folder instead of file": ("fit rec --model rec", ["--model is a model file", "swapped"]),
    "swapped arguments": ("fit model.toml --model rec", ["RECORDING = model.toml", "--model", "swapped"]),
    "parent of recordings": ("check .", ["contains recordings; give one, such as"]),
    "output is the input": ("diagnose rec --out rec", ["--out rec: is the input RECORDING"]),
    "output is something else": ("diagnose rec --out .", ["--out .: is not empty and not a diagnosis"]),
    "output below a file": ("fit rec --out log.csv/m.toml", ["log.csv is a file, not a folder"]),
    "output is a folder": ("fit rec --out rec", ["--out rec: is the input"]),
    "wrong extension": ("predict rec --model model.toml --out p.csv", ["such as p.parquet"]),
    "free parameters": (
        "predict rec --model model.toml --out p.parquet", ["no value for body.mass", "trundle fit"],
    ),
    "unknown effect": (
        "diagnose rec --no-check --without coulom_friction --out d", ["did you mean `coulomb_friction`"],
    ),
    "no map": ("import log.csv --out new", ["needs --map", "--guess"]),
    "missing map keys": (
        "import log.csv --map map.toml --out new",
        ["recording.object.footprint", "recording.wrench.frame", "recording.wrench.sign"],
    ),
    "missing keys of a guess": (
        "import log.csv --guess --out new",
        ["3 keys of the map are missing", "--set recording.wrench.sign=on_object|on_sensor", "--init"],
    ),
    "empty CSV": ("import empty.csv --guess --out new", ["empty.csv: is empty"]),
    "cut CSV": ("import cut.csv --guess --out new", ["cut.csv: row 2 has 3 cells and the header 7"]),
    "NaN column": ("import nan.csv --guess --out new", ["columns.object_x"]),
    "not a table": ("import photo.csv --guess --out new", ["photo.csv: is not a text file"]),
    "non-UTF-8 CSV": ("import latin.csv --map map.toml --out new", ["latin.csv", "encoding utf-8"]),
    "semicolons": ("import comma.csv --map map.toml --out new", ["comma.csv: ", "delimiter ','", "--guess"]),
    "out is missing": ("import log.csv --guess", ["--out DIR is missing"]),
}  # fmt: skip


@pytest.mark.parametrize("name", CASES)
def test_the_command_line_names_the_mistake(
    name: str, place: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    line, words = CASES[name]
    before = sorted(place.rglob("*"))
    try:
        status = main(line.split())
    except SystemExit as left:
        status = int(str(left.code))
    complaint = capsys.readouterr().err
    assert status == 2, complaint
    assert [word for word in words if word not in complaint] == []
    assert "Traceback" not in complaint
    assert sorted(place.rglob("*")) == before


@pytest.mark.parametrize("line", ["fit rec --out locked/m.toml", "diagnose rec --out locked/d"])
def test_a_folder_without_permission_is_named(
    line: str, place: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    (place / "locked").mkdir()
    # Root may write everywhere, so the answer of the system is replaced.
    monkeypatch.setattr(os, "access", lambda path, mode: Path(path).name != "locked")
    assert main(line.split()) == 2
    assert "no permission to write in" in capsys.readouterr().err


def changed(**columns: Any) -> trundle.Recording:
    return trundle.Recording(METADATA, {"episode_00": pushed() | columns})


PYTHON_CASES: dict[str, tuple[Callable[[], object], str]] = {
    "wrong path": (lambda: trundle.read("rek"), "rek"),
    "file instead of folder": (lambda: trundle.read("model.toml"), "model.toml"),
    "unknown effect": (lambda: trundle.diagnose("rec", without=["friction"], check=False), "coulomb"),
    "reversed time": (lambda: changed(t=pushed()["t"][::-1]), "episode_00"),
    "NaN column": (lambda: changed(object_x=np.full(400, np.nan)), "object_x"),
    "footprint": (lambda: trundle.Recording(METADATA | {"object": {}}, {"e": pushed()}), "footprint"),
    "degrees": (lambda: trundle.diagnose(changed(object_theta=60 * pushed()["object_theta"])), "degrees"),
    "millimetres": (lambda: trundle.diagnose(changed(object_x=1e3 * pushed()["object_x"])), "millimetres"),
    "empty CSV": (lambda: guess_map("empty.csv"), "is empty"),
    "missing map": (lambda: read(Path("log.csv"), "csv"), "needs --map"),
    "missing map keys": (lambda: read(Path("log.csv"), "csv", Path("map.toml")).recording(), "wrench.frame"),
}  # fmt: skip


@pytest.mark.parametrize("name", PYTHON_CASES)
def test_python_names_the_mistake(name: str, place: Path) -> None:
    work, words = PYTHON_CASES[name]
    with pytest.raises((ValueError, OSError)) as refusal:
        work()
    assert words in str(refusal.value)


def test_a_recording_without_held_out_episodes_causes_a_warning(
    place: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["check", "rec"]) == 0
    assert 'held_out = ["episode_01"]' in capsys.readouterr().out
    assert main(["fit", "rec", "--starts", "1", "--quiet"]) == 0
    assert "warning: rec: no episode is held out" in capsys.readouterr().err


def test_ctrl_c_half_way_leaves_nothing(place: Path) -> None:
    trundle.Recording(METADATA, {f"e{k}": pushed(4000) for k in range(9)}).write(place / "long")
    line = ["diagnose", "long", "--no-check", "--out", "d"]
    with interruptible([*COMMAND, *line], place) as process:
        at_work(process, 1.5)
        process.send_signal(signal.SIGINT)
        _, complaint = process.communicate(timeout=120)
    assert process.returncode == 130, complaint
    assert complaint.endswith("trundle: interrupted\n")
    assert not list(place.glob("*d"))


def test_hints_name_extras_that_exist() -> None:
    root = Path(__file__).resolve().parents[2]
    extras = tomllib.loads((root / "pyproject.toml").read_text())["project"]["optional-dependencies"]
    sources = [path.read_text(encoding="utf-8") for path in (root / "python" / "trundle").rglob("*.py")]
    named = {extra for text in sources for extra in re.findall(r"trundle\[([a-z0-9]+)\]", text)}
    assert named and named <= set(extras)
