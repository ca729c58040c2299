import io

from trundle.cli.progress import Progress


class Terminal(io.StringIO):
    def isatty(self) -> bool:
        return True


def test_a_terminal_sees_the_steps_and_is_left_clean() -> None:
    terminal = Terminal()
    with Progress("fitting", total=2, stream=terminal) as progress:
        progress.step("start 1")
        progress.step("start 2")
    lines = terminal.getvalue().split("\r\033[K")
    assert lines[1:] == [
        "fitting 0/2 (0 s)",
        "fitting 1/2 (0 s) · start 1",
        "fitting 2/2 (0 s) · start 2",
        "",
    ]


def test_a_file_sees_nothing() -> None:
    file = io.StringIO()
    with Progress("fitting", stream=file) as progress:
        progress.step()
    assert file.getvalue() == ""


def test_quiet_shows_nothing_on_a_terminal() -> None:
    terminal = Terminal()
    with Progress("fitting", quiet=True, stream=terminal) as progress:
        progress.step()
    assert terminal.getvalue() == ""
