"""Colours, missing matplotlib, notebooks, and imports on first use."""

from __future__ import annotations

import re
import struct
import subprocess
import sys
from pathlib import Path

import pytest

import trundle
from trundle import palette
from trundle.plots.style import new_figure

STYLE_SHEET = Path(trundle.__file__).parent / "report" / "templates" / "style.css"


def test_the_colours_are_those_of_the_light_theme_of_the_report() -> None:
    light = STYLE_SHEET.read_text(encoding="utf-8").partition("}")[0]
    declared = {name.upper(): colour for name, colour in re.findall(r"--(\w+):(#\w+)", light)}
    assert {name: getattr(palette, name) for name in palette.__all__} == declared


def test_importing_the_library_does_not_import_matplotlib() -> None:
    code = "import sys, trundle; dir(trundle.plots); print('matplotlib' in sys.modules)"
    ran = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert ran.stdout.strip() == "False"


def test_missing_matplotlib_names_the_extra(
    recording: trundle.Recording, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(
        trundle.TrundleError, match=re.escape("plots need matplotlib: pip install 'trundle[plots]'")
    ):
        trundle.plots.recording(recording)


def test_a_notebook_displays_a_figure_as_png() -> None:
    figure = new_figure((3.0, 2.0))
    image, size = figure._repr_png_()  # type: ignore[attr-defined]
    assert image[:8] == b"\x89PNG\r\n\x1a\n"
    assert struct.unpack(">II", image[16:24]) == (600, 400)
    assert size == {"width": 300, "height": 200}


def test_the_module_lists_its_functions_only() -> None:
    assert dir(trundle.plots) == ["diagnosis", "fit", "posterior", "recording", "residual"]
    with pytest.raises(AttributeError, match="no attribute 'nothing'"):
        _ = trundle.plots.nothing
