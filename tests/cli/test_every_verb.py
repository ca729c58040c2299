"""Requirements on every verb, including new ones."""

from pathlib import Path

import pytest

from tests.cli.walk import leaves, reads_a_file, with_missing_files
from tests.command import trundle
from trundle.cli import main
from trundle.cli.commands import discover

VERBS = sorted(leaves())
READERS = [verb for verb in VERBS if reads_a_file(verb)]


def name(verb: tuple[str, ...]) -> str:
    return " ".join(verb)


def test_the_main_verbs_exist() -> None:
    assert {"check", "diagnose", "effects", "fit", "import", "info", "predict", "simulate"} <= set(discover())


@pytest.mark.parametrize("verb", VERBS, ids=name)
def test_help_has_a_description_and_an_example(
    verb: tuple[str, ...], capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as left:
        main([*verb, "--help"])
    text = capsys.readouterr().out
    assert left.value.code == 0
    assert f"trundle {' '.join(verb)} " in text.split("example", 1)[-1]


@pytest.mark.parametrize("verb", VERBS, ids=name)
def test_an_unknown_option_is_refused(verb: tuple[str, ...], capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as left:
        main([*verb, "--no-such-option"])
    assert left.value.code == 2
    assert "--help" in capsys.readouterr().err


@pytest.mark.parametrize("verb", READERS, ids=name)
def test_a_missing_input_is_named_without_output(
    verb: tuple[str, ...], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(with_missing_files(verb)) == 2
    complaint = capsys.readouterr().err
    assert "missing/" in complaint
    assert complaint.count("\n") == 1
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("verb", READERS[:1], ids=name)
def test_errors_have_no_traceback_unless_debugging(verb: tuple[str, ...], tmp_path: Path) -> None:
    line = with_missing_files(verb)
    assert "Traceback" not in trundle(tmp_path, *line).stderr
    assert "Traceback" in trundle(tmp_path, *line, TRUNDLE_DEBUG="1").stderr
