import re
from pathlib import Path

import pytest

from tests.command import trundle
from trundle.cli import build_parser, main, unknown_verb_message
from trundle.cli.commands import discover


def test_version_is_the_package_s(tmp_path: Path) -> None:
    ran = trundle(tmp_path, "--version")
    assert ran.returncode == 0
    assert re.fullmatch(r"trundle \d+\.\d+\.\d+\n", ran.stdout)


def test_help_lists_every_verb() -> None:
    text = build_parser(discover()).format_help()
    for verb, command in discover().items():
        assert verb in text
        assert command.HELP.split()[0] in text


@pytest.mark.parametrize("verb", sorted(discover()))
def test_a_slip_of_the_finger_is_understood(verb: str) -> None:
    complaint = unknown_verb_message([verb[:-1] + "q"], discover())
    assert complaint is not None
    assert f"did you mean {verb!r}" in complaint


def test_nonsense_is_no_verb(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["zzzzzz"]) == 2
    assert capsys.readouterr().err == "trundle: there is no verb 'zzzzzz'; `trundle --help` lists them\n"


def test_no_verb_at_all_is_a_usage_error(tmp_path: Path) -> None:
    ran = trundle(tmp_path)
    assert ran.returncode == 2
    assert "trundle --help" in ran.stderr
    assert ran.stdout == ""
