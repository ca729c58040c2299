"""Each experiment rewrites only its section of the document."""

from pathlib import Path

import pytest

from trundle import TrundleError
from trundle.cli.commands.paper import CHOICES
from trundle.experiments.markdown import replace_section, table
from trundle.experiments.paper import EXPERIMENTS

ORDER = ["one", "two", "three"]


def test_only_one_section_is_rewritten(tmp_path: Path) -> None:
    path = tmp_path / "paper.md"
    replace_section(path, "three", "third", ORDER, "# Head\n")
    replace_section(path, "one", "first", ORDER, "# Head\n")
    path.write_text(path.read_text().replace("<!-- end of one -->", "<!-- end of one -->\n\nby hand"))
    before = path.read_text()
    replace_section(path, "one", "first anew", ORDER, "# Head\n")
    assert path.read_text() == before.replace("first", "first anew")
    replace_section(path, "two", "second", ORDER, "# Head\n")
    text = path.read_text()
    assert text.index("first anew") < text.index("by hand") < text.index("second") < text.index("third")
    assert list(tmp_path.iterdir()) == [path]


def test_a_missing_marker_is_named(tmp_path: Path) -> None:
    path = tmp_path / "paper.md"
    replace_section(path, "one", "first", ORDER, "# Head\n")
    path.write_text(path.read_text().replace("<!-- end of one -->", ""))
    with pytest.raises(TrundleError, match="end of one"):
        replace_section(path, "one", "again", ORDER, "# Head\n")


def test_tables_have_a_cell_for_each_head() -> None:
    assert table(["a", "b"], [["1", "2"]]) == "| a | b |\n| --- | --- |\n| 1 | 2 |"


def test_the_command_line_offers_every_experiment() -> None:
    assert ("all", *EXPERIMENTS) == CHOICES
