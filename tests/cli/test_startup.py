"""Ctrl-C while the command is still importing."""

import subprocess
import sys

import pytest

INTERRUPTED_AT = """
import os, runpy, signal, sys

class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            sys.meta_path.remove(self)
            os.kill(os.getpid(), signal.SIGINT)

signal.signal(signal.SIGINT, signal.default_int_handler)
sys.meta_path.insert(0, Finder())
sys.argv = [{program!r}, "effects"]
from trundle.cli import main
sys.exit(main())
"""


def started(module: str, program: str) -> "subprocess.CompletedProcess[str]":
    code = INTERRUPTED_AT.format(module=module, program=program)
    return subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, timeout=120)


@pytest.mark.parametrize(
    "module",
    ["trundle.objects", "trundle._native", "gymnasium", "trundle.cli", "trundle.cli.commands.effects"],
)
def test_the_command_reports_an_interrupt(module: str) -> None:
    ran = started(module, "/usr/bin/trundle")
    assert (ran.returncode, ran.stdout, ran.stderr) == (130, "", "trundle: interrupted\n")


def test_importing_trundle_does_not_import_templates() -> None:
    code = "import sys, trundle; sys.exit('jinja2' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], timeout=120).returncode == 0


def test_a_program_that_imports_trundle_gets_keyboard_interrupt() -> None:
    ran = started("trundle.objects", "/home/somebody/experiment.py")
    assert ran.returncode != 0
    assert ran.stderr.rstrip().endswith("KeyboardInterrupt")
