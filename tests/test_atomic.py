"""Files and folders are written atomically."""

import os
import random
import resource
import signal
import sys
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import trundle
from trundle import TrundleError, atomic
from trundle.atomic import atomic_file, atomic_folder, write_text
from trundle.picture import draw


def test_a_file_is_replaced_atomically(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "a.txt"
    write_text(path, "before")
    with pytest.raises(KeyboardInterrupt), atomic_file(path) as part:
        part.write_text("hal")
        assert path.read_text() == "before"
        raise KeyboardInterrupt
    assert [(p.name, p.read_text()) for p in path.parent.iterdir()] == [("a.txt", "before")]


def test_a_folder_is_replaced_atomically(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    for text in ("one", "two"):
        with atomic_folder(folder, "mark", "an item") as partial:
            (partial / "mark").write_text(text)
            (partial / text).touch()
    with pytest.raises(ZeroDivisionError), atomic_folder(folder, "mark", "an item") as partial:
        (partial / "mark").write_text("three")
        raise ZeroDivisionError
    assert (folder / "mark").read_text() == "two"
    assert sorted(p.name for p in folder.iterdir()) == ["mark", "two"]
    assert list(tmp_path.iterdir()) == [folder]


def test_an_unrelated_folder_is_not_changed(tmp_path: Path) -> None:
    (tmp_path / "precious").touch()
    with (
        pytest.raises(TrundleError, match="is not empty and not an item"),
        atomic_folder(tmp_path, "mark", "an item"),
    ):
        pass
    assert [p.name for p in tmp_path.iterdir()] == ["precious"]


def forked(task: Callable[[], None], patience: float = 60.0) -> int:
    """Return the exit status of a task in a child; negative after a signal or a timeout."""
    child = os.fork()
    if child == 0:
        status = 1
        try:
            task()
            status = 0
        except BaseException:
            traceback.print_exc()
        finally:
            os._exit(status)
    end = time.monotonic() + patience
    while time.monotonic() < end:
        ended, status = os.waitpid(child, os.WNOHANG)
        if ended:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.001)
    os.kill(child, signal.SIGKILL)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])


def write_item(folder: Path, text: str) -> None:
    with atomic_folder(folder, "mark", "an item") as partial:
        (partial / "mark").write_text(text)
        (partial / text).mkdir()
        (partial / text / "deep").touch()


TOUCHING = ("open", "os.", "shutil.", "replace")
"""Prefixes of the names of functions that access the disk."""


def killed_before(step: int) -> None:
    """Kill this process before a given access to the disk."""
    left = step

    def count(event: str, _: Any = None) -> None:
        nonlocal left
        if event.startswith(TOUCHING) and event != "os.kill":
            left -= 1
            if left < 0:
                os.kill(os.getpid(), signal.SIGKILL)

    how = vars(atomic)["_replace_folder"]

    def replaced(*paths: Any) -> None:
        count("replace")
        how(*paths)
        count("replaced")

    vars(atomic)["_replace_folder"] = replaced
    sys.addaudithook(count)


def test_a_folder_survives_a_kill_at_every_step(tmp_path: Path) -> None:
    folder, seen = tmp_path / "out", []
    for step in range(1000):
        write_item(folder, "one")

        def replace(step: int = step) -> None:
            killed_before(step)
            write_item(folder, "two")

        status = forked(replace)
        text = (folder / "mark").read_text()
        assert sorted(p.name for p in folder.iterdir()) == ["mark", text]
        assert [p.name for p in (folder / text).iterdir()] == ["deep"]
        seen.append(text)
        if status == 0:
            break
        assert status == -signal.SIGKILL
    assert seen == sorted(seen), "once the new one is there it stays"
    assert seen.count("one") > 5
    assert seen.count("two") > 3


def test_a_folder_moved_by_a_killed_process_is_restored(tmp_path: Path) -> None:
    """For file systems that cannot exchange folders."""
    folder = tmp_path / "out"
    write_item(folder, "one")
    folder.rename(tmp_path / ".out.replaced")
    with pytest.raises(ZeroDivisionError), atomic_folder(folder, "mark", "an item"):
        raise ZeroDivisionError
    assert (folder / "mark").read_text() == "one"
    assert list(tmp_path.iterdir()) == [folder]


def recording(samples: int) -> trundle.Recording:
    t = np.arange(samples) / 10
    metadata = {
        "format": "trundle-recording/1",
        "name": str(samples),
        "object": {"dof": ["x"]},
        "wrench": {
            "frame": "object",
            "reference": "object",
            "sign": "on_object",
            "raw": False,
            "contact": "grasp",
            "source": "commanded",
        },
    }
    return trundle.Recording(metadata, {"a": {"t": t, "object_x": 0.1 * t**2, "force_x": np.cos(t)}})


def test_a_recording_survives_a_kill_at_any_instant(tmp_path: Path) -> None:
    folder, choose = tmp_path / "run", random.Random(0)
    two = [recording(50), recording(60)]
    two[0].write(folder)

    def endless() -> None:
        while True:
            for one in two:
                one.write(folder)

    for _ in range(40):
        assert forked(endless, choose.uniform(0.005, 0.03)) == -signal.SIGKILL
        assert trundle.read(folder) in two


def test_a_full_disk_is_reported_and_leaves_nothing(tmp_path: Path) -> None:
    """Simulated by a limit on the size of files."""
    picture, folder = tmp_path / "p.png", tmp_path / "out"
    run = recording(50)

    def full() -> None:
        resource.setrlimit(resource.RLIMIT_FSIZE, (1000, 1000))
        with pytest.raises(OSError, match=r"p\.png") as refused:
            draw(run, picture)
        assert refused.value.filename == str(picture)
        with pytest.raises(OSError, match="out"), atomic_folder(folder, "mark", "an item") as partial:
            (partial / "big").write_bytes(bytes(10_000))
        with pytest.raises(OSError, match=r"a\.txt"):
            write_text(tmp_path / "a.txt", "x" * 10_000)
        with pytest.raises(TrundleError, match=r"/out/a\.csv: cannot be written"):
            run.write(folder)

    assert forked(full) == 0
    assert list(tmp_path.iterdir()) == []
