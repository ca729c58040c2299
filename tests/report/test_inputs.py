"""Fingerprints agree with those of the shell."""

from __future__ import annotations

import hashlib
import subprocess
from pathlib import Path

from tests.report.answers import Sample
from tests.report.test_page import words
from trundle.report import inputs, render
from trundle.report.inputs import fingerprint


def folder(path: Path) -> Path:
    path.mkdir()
    for name, text in (
        ("recording.toml", "a = 1\n"),
        ("episode_01.csv", "t\n1\n"),
        ("Z.csv", "z"),
        (".hidden", "h"),
    ):
        (path / name).write_text(text, encoding="utf-8")
    (path / "folder").mkdir()
    return path


def test_a_folder_is_its_files_in_order_of_their_names(tmp_path: Path) -> None:
    expected = hashlib.sha256(b"z" + b"t\n1\n" + b"a = 1\n").hexdigest()
    assert fingerprint(folder(tmp_path / "a recording")) == expected


def test_the_shown_command_prints_the_same(tmp_path: Path) -> None:
    model = tmp_path / "model.toml"
    model.write_text("x", encoding="utf-8")
    for entry in inputs(recording=folder(tmp_path / "it's here"), model=str(model)):
        shell = f"export LC_ALL=C; {entry['check']} 2>/dev/null"
        printed = subprocess.run(["sh", "-c", shell], capture_output=True, text=True, check=False)
        assert printed.stdout.split()[0] == entry["sha256"]


def test_objects_in_memory_have_no_fingerprint(tmp_path: Path) -> None:
    assert inputs(recording=object(), model=None) == []


def test_the_page_shows_them(samples: dict[str, Sample]) -> None:
    text = words(render(*samples["certified"]))
    assert f"SHA-256 of the recording {'0123456789abcdef' * 4} as printed by cat recordings/table/*" in text
    assert "SHA-256" not in words(render(*samples["table"]))
