import io
import re
from itertools import pairwise

import pytest

from trundle.cli import progress as module
from trundle.cli.progress import Progress, format_duration


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_a_terminal_shows_progress_and_is_cleared() -> None:
    terminal = Terminal()
    with Progress("fitting", total=2, stream=terminal) as progress:
        progress.step("start 1")
        progress.step("start 2")
    lines = terminal.getvalue().split("\r\033[K")
    assert lines[1:] == [
        "fitting 0/2 (0 s)",
        "fitting 1/2 (0 s, about 0 s left) · start 1",
        "fitting 2/2 (0 s) · start 2",
        "",
    ]


def test_a_file_receives_no_progress() -> None:
    file = io.StringIO()
    with Progress("fitting", stream=file) as progress:
        progress.step()
    assert file.getvalue() == ""


def test_quiet_hides_progress() -> None:
    terminal = Terminal()
    with Progress("fitting", quiet=True, stream=terminal) as progress:
        progress.step()
    assert terminal.getvalue() == ""


class Clock:
    """A clock that advances by ten seconds at each call."""

    def __init__(self) -> None:
        self.now = 0.0

    def monotonic(self) -> float:
        self.now += 10.0
        return self.now


def test_the_remaining_time_is_estimated_from_the_share(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(module, "time", Clock())
    terminal = Terminal()
    with Progress("diagnosing", stream=terminal) as progress:
        progress.share("single effects", 0.001)
        progress.share("single effects", 0.25)
        progress.share("figures", 1.0)
    lines = terminal.getvalue().split("\r\033[K")[2:]
    assert lines == [
        "diagnosing 0 % (20 s) · single effects",
        "diagnosing 25 % (30 s, about 2 min left) · single effects",
        "diagnosing 100 % (40 s) · figures",
        "",
    ]


def test_progress_never_decreases() -> None:
    terminal = Terminal()
    with Progress("fitting", stream=terminal) as progress:
        for done in (0.1, 0.4, 0.2, 0.0, 0.5):
            progress.share("fit", done)
    shown = [int(share) for share in re.findall(r"(\d+) %", terminal.getvalue())]
    assert shown == [10, 40, 40, 40, 50]
    assert all(before <= after for before, after in pairwise(shown))


def test_durations_are_formatted() -> None:
    assert [format_duration(s) for s in (3.2, 61.0, 7500.0)] == ["3 s", "1 min", "2 h 05 min"]
