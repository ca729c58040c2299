import re
from pathlib import Path

import pytest

from tests.command import trundle
from trundle.cli import build_parser, main, unknown_verb_message
from trundle.cli.commands import discover


def test_version_is_that_of_the_package(tmp_path: Path) -> None:
    ran = trundle(tmp_path, "--version")
    assert ran.returncode == 0
    assert re.fullmatch(r"trundle \d+\.\d+\.\d+\n", ran.stdout)


def test_help_lists_every_verb() -> None:
    text = build_parser(discover()).format_help()
    for verb, command in discover().items():
        assert verb in text
        assert command.HELP.split()[0] in text


@pytest.mark.parametrize("verb", sorted(discover()))
def test_a_misspelt_verb_gets_a_suggestion(verb: str) -> None:
    message = unknown_verb_message([verb[:-1] + "q"], discover())
    assert message is not None
    assert f"did you mean {verb!r}" in message


def test_an_unknown_verb_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["zzzzzz"]) == 2
    assert capsys.readouterr().err == "trundle: unknown verb 'zzzzzz'; `trundle --help` lists all verbs\n"


def test_a_missing_verb_is_a_usage_error(tmp_path: Path) -> None:
    ran = trundle(tmp_path)
    assert ran.returncode == 2
    assert "trundle --help" in ran.stderr
    assert ran.stdout == ""
