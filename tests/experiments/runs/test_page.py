"""The page of a run: reproducible, and complete."""

import json
import re
from itertools import pairwise

import pytest

from tests.experiments.runs.samples import SAMPLES, episode
from trundle.experiments.runs.config import Settings
from trundle.experiments.runs.page import render

SETTINGS = Settings("trundle/PushAround-v0", arguments={"hidden": "locked"}, text="# <not> & markup")


def page(name: str) -> str:
    return render(SETTINGS, "run.toml", [episode(**given) for given in SAMPLES[name]])


@pytest.mark.parametrize("name", sorted(SAMPLES))
def test_the_same_input_gives_the_same_bytes_without_nan(name: str) -> None:
    text = page(name)
    assert text == page(name)
    assert not re.search(r"\b(nan|NaN|inf|None)\b", text.rpartition("<script>")[0])
    assert "http://" not in text and "https://" not in text


def test_the_settings_are_shown_as_text() -> None:
    assert "# &lt;not&gt; &amp; markup" in page("found")


def test_the_ellipse_shrinks_from_tile_to_tile() -> None:
    tiles = page("found").split('class="tiles"')[1].split('class="panels"')[0]
    shown = tiles.split("<figure>")[1:]
    # The first ellipse of a tile is on the object, the second in the magnified view.
    sizes = [float(re.findall(r'<ellipse rx="([\d.]+)"', figure)[0]) for figure in shown]
    assert len(sizes) == 6
    assert all(later < earlier for earlier, later in pairwise(sizes))


def test_the_data_of_the_slider_cover_every_sample() -> None:
    found = episode(friction=True)
    data = json.loads(page("friction").split('<script type="application/json">')[1].split("</script>")[0])
    length = len(found.t)
    assert [len(data[name]) for name in ("poses", "forces", "texts")] == [length] * 3
    starts = [start for start, _ in data["estimates"]]
    assert starts == [0, *(10 * (k + 1) for k in range(len(found.updates)))]
    assert data["estimates"][0][1] == "" and "ellipse" in data["estimates"][1][1]


def test_named_effects_are_in_the_table_with_their_truth() -> None:
    text = page("friction")
    assert "dry friction, new grasp at (0.00, 0.40) m" in text
    assert re.search(r"dry friction, force</th><td>[^<]*20\.0.*?<td>20 N</td>", text)


def test_several_episodes_have_separate_sections() -> None:
    text = page("several")
    assert "Reached the goal in 2 of 3 episodes" in text
    names = re.findall(r'id="([^"]+)"', text)
    assert len(names) == len(set(names))
    assert [f'href="#e{number}"' in text for number in range(3)] == [True] * 3
