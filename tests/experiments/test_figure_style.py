"""Figures have the same bytes whenever they are drawn."""

from pathlib import Path

import pytest

from trundle.experiments import figure_style


@pytest.mark.parametrize("suffix", ["png", "svg"])
def test_a_figure_drawn_again_has_the_same_bytes(suffix: str, tmp_path: Path) -> None:
    for name in ("one", "two"):
        figure, (axes,) = figure_style.sheet(1, 1, (3.0, 2.0))
        axes.plot([0, 1], [0, 1], label="line")
        figure_style.legend(axes)
        figure_style.save(figure, tmp_path / f"{name}.{suffix}")
    assert (tmp_path / f"one.{suffix}").read_bytes() == (tmp_path / f"two.{suffix}").read_bytes()
