"""Every path of every verb is declared, so that it is checked before the work."""

from pathlib import Path

import pytest

import trundle
from tests.cli.walk import find, leaves
from trundle.cli import main
from trundle.cli.paths import Output, check_output

CHECKED_BY_THE_VERB = {("diagnose", "out")}
"""The output of a diagnosis has one folder for each recording."""
RESUMED = {"work", "configs"}
"""Folders of work in progress, and of settings."""


@pytest.mark.parametrize("verb", sorted(leaves()), ids=" ".join)
def test_every_path_is_declared(verb: tuple[str, ...]) -> None:
    parser = find(verb)
    declared = parser.get_default("paths") or {}
    paths = {action.dest for action in parser._actions if action.type is Path} - RESUMED
    assert {dest for dest in paths if (verb[-1], dest) not in CHECKED_BY_THE_VERB} <= set(declared)


@pytest.mark.parametrize("verb", ["compare", "paper", "prove"])
def test_no_verb_writes_into_the_documentation_by_default(verb: str) -> None:
    assert "default docs" not in find((verb,)).format_help()


def test_an_earlier_output_is_replaced_and_missing_folders_are_created(tmp_path: Path) -> None:
    wanted = Output("--out", "folder", marker="diagnosis.json", content="a diagnosis")
    (tmp_path / "old").mkdir()
    (tmp_path / "old" / "diagnosis.json").write_text("{}")
    for name in ("old", "new", "far/away"):
        check_output(tmp_path / name, wanted, {})


def test_two_recordings_of_one_name_are_not_diagnosed_into_one_folder(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    for folder in ("a/rec", "b/rec"):
        Path(folder).mkdir(parents=True)
        Path(folder, "recording.toml").write_text("")
    assert main(["diagnose", "a/rec", "b/rec", "--out", "d"]) == 2
    assert "d/rec: would be the output of both a/rec and b/rec" in capsys.readouterr().err


def test_a_design_between_two_wrong_models_causes_a_warning(tmp_path: Path) -> None:
    root = Path(__file__).resolve().parents[2]
    recording = trundle.simulate(root / "configs" / "experiments" / "demo.toml")
    files = []
    for kind in ("floor_slope", "force_bias"):
        files.append(tmp_path / f"{kind}.toml")
        effects = "".join(f'[[effect]]\nkind = "{name}"\n' for name in ("viscous_wheel", kind))
        files[-1].write_text(f'format = "trundle-model/1"\n{effects}')
    found = trundle.design(*files, recording=recording)
    assert len(found.warnings) == 1
    assert "with floor_slope, " in found.warnings[0] and "rms remain" in found.warnings[0]
