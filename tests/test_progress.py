import io
import re
import sys
from collections.abc import Callable
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import pytest

from trundle import progress as module
from trundle.progress import Progress, format_duration, report_progress


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


@pytest.fixture(autouse=True)
def every_update_is_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "120")


def drawn(terminal: Terminal) -> list[str]:
    """Return the drawn lines without the bar."""
    lines = terminal.getvalue().replace("\x1b[A", "").split("\r")
    return [re.sub(r"\|.*?\| ", " ", line).rstrip() for line in lines if line.strip()]


def test_steps_are_counted_and_the_line_is_removed() -> None:
    terminal = Terminal()
    with Progress("fitting", total=2, stream=terminal) as progress:
        progress.step("start 1")
        progress.step("start 2")
    lines = drawn(terminal)
    assert lines[0].startswith("fitting: 0/2")
    assert lines[-1].startswith("fitting: 2/2") and lines[-1].endswith("start 2")
    assert terminal.getvalue().endswith("\r") and terminal.getvalue().split("\r")[-2].strip() == ""


def test_a_file_receives_no_progress() -> None:
    file = io.StringIO()
    with Progress("fitting", stream=file) as progress:
        progress.step()
        progress.share("fit", 0.5)
    assert file.getvalue() == ""


def test_quiet_hides_progress() -> None:
    terminal = Terminal()
    with Progress("fitting", quiet=True, stream=terminal) as progress:
        progress.share("fit", 0.5)
    assert terminal.getvalue() == ""


def test_the_remaining_time_is_estimated_from_the_share() -> None:
    terminal = Terminal()
    with Progress("diagnosing", stream=terminal) as progress:
        progress._bar.start_t -= 30.0
        progress.share("single effects", 0.25)
    assert re.match(r"diagnosing:  25% 00:30<01:3\d, single effects", drawn(terminal)[-1])


def test_progress_never_decreases_and_unfinished_work_is_not_complete() -> None:
    terminal = Terminal()
    with Progress("fitting", stream=terminal) as progress:
        for done in (0.1, 0.4, 0.2, 0.0, 0.5, 0.999):
            progress.share("fit", done)
    shown = [int(share) for share in re.findall(r"(\d+)%", terminal.getvalue())]
    assert (shown[0], shown[-1]) == (10, 99)
    assert all(before <= after for before, after in pairwise(shown))


def work(report: Callable[[str, float], object] | None) -> bool:
    """Report half of the work; return whether anything receives it."""
    if report is not None:
        report("half", 0.5)
    return report is not None


def test_a_function_receives_the_progress() -> None:
    seen: list[tuple[str, float]] = []
    with report_progress(lambda stage, done: seen.append((stage, done)), "fit") as report:
        work(report)
    assert seen == [("half", 0.5)]


def test_true_shows_a_bar_on_a_terminal(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    with report_progress(True, "fit") as report:
        work(report)
    assert "fit:  50%" in terminal.getvalue()


def test_the_default_shows_a_bar_in_notebooks_only(monkeypatch: pytest.MonkeyPatch) -> None:
    file = io.StringIO()
    monkeypatch.setattr(sys, "stderr", file)
    with report_progress(None, "fit") as report:
        assert not work(report)
    kernel: Any = SimpleNamespace(get_ipython=lambda: SimpleNamespace(config={"IPKernelApp": {}}))
    monkeypatch.setitem(sys.modules, "IPython", kernel)
    assert module.in_notebook()
    with report_progress(None, "fit") as report:
        assert work(report)
    with report_progress(False, "fit") as report:
        assert not work(report)
    assert "fit:  50%" in file.getvalue()


def test_durations_are_formatted() -> None:
    assert [format_duration(s) for s in (3.2, 61.0, 7500.0)] == ["3 s", "1 min", "2 h 05 min"]
