"""The page reports the diagnosis and nothing else, whatever names and gaps it contains."""

from __future__ import annotations

import base64
import copy
import hashlib
import re
from html.parser import HTMLParser
from itertools import pairwise
from typing import Any

import pytest

from trundle.report import render

Sample = tuple[dict[str, Any], dict[str, Any]]


class Outline(HTMLParser):
    """Open elements, ids and texts of a page; fails where a tag closes what is not open."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[str] = []
        self.ids: list[str] = []
        self.text = ""

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        self.ids += [value for name, value in attrs if name == "id" and value]
        if tag not in ("meta", "br", "col"):
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if not {"style", "script"} & set(self.open):
            self.text += f"{data} "


def outline(page: str) -> Outline:
    parsed = Outline()
    parsed.feed(page)
    assert parsed.open == []
    return parsed


def words(page: str) -> str:
    return re.sub(r"[ \n]+", " ", outline(page).text)


def test_every_page_is_one_well_formed_file_without_network(page: str) -> None:
    parsed = outline(page)
    assert not {"link", "img", "iframe"} & set(parsed.tags)
    assert parsed.tags.count("script") == 1 and "<script>" in page
    assert len(parsed.ids) == len(set(parsed.ids))
    assert not re.search(r"https?:|url\(|@import|\bnan\b|\binf\b|None", page)


def test_the_policy_of_the_page_allows_its_own_script_only(samples: dict[str, Sample]) -> None:
    page = render(*samples["table"])
    script = page.partition("<script>")[2].partition("</script>")[0]
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    policy = f"default-src 'none'; style-src 'unsafe-inline'; script-src 'sha256-{digest}'"
    assert f'<meta http-equiv="Content-Security-Policy" content="{policy}">' in page


def test_every_page_is_small(page: str) -> None:
    assert len(page.encode()) < 1_500_000


def test_the_same_input_gives_the_same_bytes(sample: Sample, page: str) -> None:
    assert render(*copy.deepcopy(sample)) == page


def test_every_figure_has_title_and_description(page: str) -> None:
    drawings = re.findall(r'<svg viewBox="[^"]*" role="img".*?</title><desc[^>]*>[^<]{20,}', page)
    assert len(drawings) == page.count("<figure>") > 0


def test_several_effects_are_numbered_as_on_the_maps(samples: dict[str, Sample]) -> None:
    text = words(render(*samples["events"]))
    assert "1. What wheel_event does" in text and "3. What floor_patch does" in text
    assert "1. Dry friction" not in words(render(*samples["table"]))


def test_headings_and_tables_read_in_order(page: str) -> None:
    levels = [int(level) for level in re.findall(r"<h([1-6])[ >]", page)]
    assert levels.count(1) == 1 and levels[0] == 1
    assert all(after - before <= 1 for before, after in pairwise(levels))
    assert "<th></th>" not in page and not re.search(r'<th scope="\w+"></th>', page)
    assert page.count('role="img"') == page.count("<figure>") == page.count("<desc")


def test_the_verdict_comes_first_with_its_figures(samples: dict[str, Sample]) -> None:
    text = words(render(*samples["table"]))
    assert text.index("Dry friction is missing from the simulation.") < text.index("Missing effects")
    assert "On held-out pushes the open-loop position error falls from 12.3\xa0cm to 8.0\xa0mm" in text


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("tied", "An offset of the force sensor or a sloping floor is missing from the simulation."),
        ("consistent", "Nothing is missing"),
        ("unexplained", "Something is missing that no effect in the catalogue explains."),
        ("unexplained", "It is strongest in episode_05 at 0.60\N{EN DASH}1.40\xa0s."),
        (
            "discrepancy",
            "depends on the place in the room and the heading; this force improves predictions but is not an",
        ),
        ("rail", "On held-out runs"),
        ("rail", "there is no heading on a rail"),
        ("quasi_static", "quasi-static pushes do not determine the mass"),
        ("quasi_static", "the error of the required force falls from 0.71\xa0N to 0.14\xa0N"),
    ],
)
def test_each_verdict_is_a_sentence(samples: dict[str, Sample], name: str, sentence: str) -> None:
    assert sentence in words(render(*samples[name]))


def test_reparameterised_says_that_values_are_wrong(samples: dict[str, Sample]) -> None:
    diagnosis, series = samples["table"]
    text = words(render(diagnosis | {"verdict": "reparameterised", "missing": []}, series))
    assert "No effect is missing, but the parameter values of the simulation are wrong." in text
    assert "with refitted values" in text


def test_what_is_not_identifiable_is_never_a_number(samples: dict[str, Sample]) -> None:
    text = words(render(*samples["table"]))
    assert "not identifiable" in text
    assert "77.8" not in text and "77.77" not in text
    assert "3.33" not in words(render(*samples["quasi_static"]))


def test_a_rail_and_slow_pushes_draw_no_path(samples: dict[str, Sample]) -> None:
    assert 'id="object-title"' not in render(*samples["rail"])
    page = render(*samples["quasi_static"])
    assert 'id="motion-0-title"' not in page
    assert 'id="agreement-2-title"' in page


def test_names_from_the_recording_stay_text(samples: dict[str, Sample]) -> None:
    evil = "<script>alert(1)</script>\"'&\x00"
    diagnosis, series = copy.deepcopy(samples["table"])
    diagnosis["recording"] = evil
    diagnosis["missing"][0] |= {
        "effect": evil,
        "statement": evil,
        "parameters": {evil: {"mean": 1.0, "unit": evil}},
    }
    diagnosis["mismatch"] |= {
        "regime": evil,
        "windows": [{"episode": evil, "start": 0, "end": 1, "strength": 5}],
    }
    diagnosis["alternatives"] = [{"effect": evil, "probability": 0.1, "experiment": evil}]
    diagnosis["tied"] = [[evil, evil + "b"]]
    diagnosis["nominal"]["before"] = {evil: {"mean": 1.0, "unit": evil}}
    series |= {"command": evil, "version": evil, "seed": evil}
    for episode in series["episodes"]:
        episode["name"] = evil
    series["candidates"] = [{"effects": [evil], "log_evidence": 0.0, "log_score": None, "probability": 1.0}]
    page = render(diagnosis, series)
    assert outline(page).tags.count("script") == 1
    assert "alert(1)" in words(page)


@pytest.mark.parametrize("nothing", [None, float("nan")])
def test_gaps_anywhere_leave_a_page(sample: Sample, nothing: float | None) -> None:
    diagnosis, series = copy.deepcopy(sample)
    for episode in series["episodes"]:
        for name in ("observed", "before", "after"):
            if episode[name] is not None:
                episode[name][1:4] = [[nothing] * 3] * 3
    page = render(emptied(diagnosis, nothing), emptied(series | {"episodes": []}, nothing))
    assert not re.search(r"\bnan\b|None", page)
    assert not re.search(r"\bnan\b", render(diagnosis, series))


def emptied(value: Any, nothing: float | None) -> Any:
    """The same structure with every number gone."""
    if isinstance(value, dict):
        return {key: emptied(entry, nothing) for key, entry in value.items()}
    if isinstance(value, list):
        return [emptied(entry, nothing) for entry in value]
    return value if isinstance(value, bool | str) else nothing


def test_an_empty_diagnosis_has_a_page() -> None:
    text = words(render({}, {}))
    assert "No verdict was reached." in text
    assert "No prediction error could be computed" in text


def test_a_simulation_that_diverges_does_not_hide_the_recording(samples: dict[str, Sample]) -> None:
    diagnosis, series = copy.deepcopy(samples["table"])
    for episode in series["episodes"]:
        episode["before"] = [[1e9 * x, 1e9 * y, theta] for x, y, theta in episode["before"]]
    page = render(diagnosis, series)
    bars = re.findall(r'data-length="[^"]*">([\d.]+)\xa0(cm|m)<', page)
    assert bars and all(unit == "cm" or float(size) <= 5.0 for size, unit in bars)


def test_a_matrix_is_shown_row_by_row(samples: dict[str, Sample]) -> None:
    diagnosis, series = copy.deepcopy(samples["table"])
    damping = {"mean": [[15.0, 0.5, 1.0], [0.5, 180.0, 2.0], [1.0, 2.0, 44.0]], "sd": None, "unit": "SI"}
    diagnosis["missing"][0]["parameters"] = {"damping": damping}
    assert "y 0.5 180 2" in words(render(diagnosis, series))


def test_places_in_world_and_time_are_marked(samples: dict[str, Sample]) -> None:
    diagnosis, series = copy.deepcopy(samples["table"])
    diagnosis["missing"][0]["where"] = {
        "world_point": {"mean": [1.0, 0.5], "sd": [0.01, 0.01]},
        "world_region": [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]],
        "event": {"episode": "episode_04", "time": {"mean": 2.31, "sd": 0.02}},
    }
    page = render(diagnosis, series)
    assert 'class="region"' in page and 'class="event"' in page
    text = words(page)
    assert "In the world at (1.000 ± 0.010, 0.500 ± 0.010)\xa0m." in text
    assert "In episode_04 at 2.31 ± 0.02\xa0s." in text
