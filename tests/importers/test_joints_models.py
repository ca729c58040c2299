"""Models that a recording of joints names are copied into it."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from trundle.importers import Imported, MapError
from trundle.importers.joints.documents import add_models


def recording(model: Any, **episodes: Any) -> Imported:
    return Imported({"mechanism": {"model": model}, "episode": episodes}, {})


def test_models_and_included_files_are_copied(tmp_path: Path) -> None:
    (tmp_path / "robots").mkdir()
    (tmp_path / "robots" / "arm.xml").write_text('<mujoco><include file="parts.xml"/></mujoco>')
    (tmp_path / "robots" / "parts.xml").write_text("<mujocoinclude/>")
    (tmp_path / "robots" / "heavy.urdf").write_text("<robot name='µ'/>", encoding="utf-8")
    found = recording("robots/arm.xml", heavy={"model": "robots/heavy.urdf"}, light={"payload": {}})
    add_models(found, tmp_path)
    assert found.metadata["mechanism"]["model"] == "arm.xml"
    assert found.metadata["episode"] == {"heavy": {"model": "heavy.urdf"}, "light": {"payload": {}}}
    assert sorted(found.files) == ["arm.xml", "heavy.urdf", "parts.xml"]


@pytest.mark.parametrize(
    ("files", "model", "message"),
    [
        ({}, "arm.xml", r"`recording\.mechanism\.model`: .*arm\.xml: No such file .* relative to the map"),
        ({"arm.xml": "<mujoco>"}, "arm.xml", r"arm\.xml is not an MJCF or URDF file: no element found"),
        ({"arm.xml": "not XML"}, "arm.xml", r"arm\.xml is not an MJCF or URDF file"),
        (
            {"arm.xml": "<a><include file='../b.xml'/></a>"},
            "arm.xml",
            r"includes '\.\./b\.xml'; move it next to",
        ),
        ({"arm.xml": "<a><include file='arm.xml'/></a>"}, "arm.xml", r"arm\.xml includes itself"),
        ({"arm.xml": "<a><include/></a>"}, "arm.xml", r"arm\.xml includes ''"),
        ({}, 3, r"`recording\.mechanism\.model` = 3: it is the path"),
    ],
)
def test_unusable_models_are_named(tmp_path: Path, files: dict[str, str], model: Any, message: str) -> None:
    for name, text in files.items():
        (tmp_path / name).write_text(text)
    with pytest.raises(MapError, match=message):
        add_models(recording(model), tmp_path)


def test_two_models_of_one_name_are_refused(tmp_path: Path) -> None:
    for name in ("a", "b"):
        (tmp_path / name).mkdir()
        (tmp_path / name / "arm.xml").write_text(f"<{name}/>")
    with pytest.raises(MapError, match=r"`recording\.episode\.x\.model`: two files are named arm\.xml"):
        add_models(recording("a/arm.xml", x={"model": "b/arm.xml"}), tmp_path)
