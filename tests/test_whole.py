"""What is written appears whole or not at all."""

from pathlib import Path

import pytest

from trundle import TrundleError
from trundle.whole import whole_file, whole_folder, write_text


def test_a_file_is_replaced_only_by_a_whole_one(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "a.txt"
    write_text(path, "before")
    with pytest.raises(KeyboardInterrupt), whole_file(path) as part:
        part.write_text("hal")
        assert path.read_text() == "before"
        raise KeyboardInterrupt
    assert [(p.name, p.read_text()) for p in path.parent.iterdir()] == [("a.txt", "before")]


def test_a_folder_is_replaced_only_by_a_whole_one(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    for text in ("one", "two"):
        with whole_folder(folder, "mark", "a thing") as partial:
            (partial / "mark").write_text(text)
            (partial / text).touch()
    with pytest.raises(ZeroDivisionError), whole_folder(folder, "mark", "a thing") as partial:
        (partial / "mark").write_text("three")
        raise ZeroDivisionError
    assert (folder / "mark").read_text() == "two"
    assert sorted(p.name for p in folder.iterdir()) == ["mark", "two"]
    assert list(tmp_path.iterdir()) == [folder]


def test_a_folder_of_something_else_is_left_alone(tmp_path: Path) -> None:
    (tmp_path / "precious").touch()
    with (
        pytest.raises(TrundleError, match="holds something else than a thing"),
        whole_folder(tmp_path, "mark", "a thing"),
    ):
        pass
    assert [p.name for p in tmp_path.iterdir()] == ["precious"]
