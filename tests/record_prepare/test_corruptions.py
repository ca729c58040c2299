"""`trundle.check` on clean and corrupted recordings with varied instruments."""

from __future__ import annotations

import re
from copy import deepcopy
from functools import cache
from typing import Any

import numpy as np
import pytest

import trundle
from tests.record_prepare.corruptions import CORRUPTIONS, Corruption, late
from tests.record_prepare.varied import Drawn, draw, recording

SHORT: dict[str, Any] = {
    "episodes": 5,
    "seconds": 5.0,
    "rates": (100.0, 100.0),
    "contact": "grasp",
    "slow": False,
    "raw": False,
    "mass_given": True,
    "sign": "on_object",
}
"""Recordings that are fast to draw, with average instruments."""
SHORT_SEED = 3
FIRST = 40_000
"""First seed of the recordings that the slow tests draw."""
CLEAN = 60
EACH = 10
"""Minimum share of corrupted recordings in which each corruption is found."""
BLAMED = {61008: "a lag under a convention that hardly helps", 61038: "a law that explains no episode well"}
"""Seeds of former false alarms, and their cause."""
INERTIAL = (61003, 61011)
"""Recordings at 100 Hz with much acceleration, in which a short delay is detectable."""


@cache
def short(frame: str, contact: str = "grasp") -> Drawn:
    return draw(SHORT_SEED, **{**SHORT, "frame": frame, "contact": contact})


@cache
def full(seed: int, chosen: tuple[tuple[str, Any], ...]) -> Drawn:
    return draw(seed, **dict(chosen))


def warned(findings: trundle.Findings) -> list[trundle.Finding]:
    return [finding for finding in findings if finding.severity != "note"]


def check(corruption: Corruption, drawn: Drawn) -> trundle.Findings:
    return trundle.check(trundle.Recording(*corruption.apply(drawn)))


def key(corruption: Corruption) -> tuple[tuple[str, Any], ...]:
    return tuple(sorted(corruption.chosen.items()))


@pytest.mark.parametrize("corruption", CORRUPTIONS.values(), ids=CORRUPTIONS.keys())
def test_each_corruption_is_found_with_its_remedy(corruption: Corruption) -> None:
    clean = short(corruption.chosen.get("frame", "sensor"), corruption.chosen.get("contact", "grasp"))
    findings = check(corruption, clean)
    assert corruption.found(findings), findings
    kinds = [(finding.kind, finding.sentence) for finding in warned(findings)]
    assert len(kinds) <= 4, "findings are grouped, not repeated by episode"


@pytest.mark.parametrize("contact", ["grasp", "compliant", "point"])
@pytest.mark.parametrize("frame", ["sensor", "object", "world"])
def test_a_clean_recording_has_no_findings(contact: str, frame: str) -> None:
    assert warned(trundle.check(recording(short(frame, contact)))) == []


@pytest.mark.parametrize("seed", BLAMED, ids=str)
def test_a_former_false_alarm_has_no_findings(seed: int) -> None:
    assert warned(trundle.check(recording(draw(seed)))) == []


@pytest.mark.parametrize("seed", INERTIAL)
def test_a_delay_of_half_a_sample_is_estimated(seed: int) -> None:
    drawn = draw(seed, slow=False, rates=(100.0, 100.0), contact="grasp")
    assert warned(trundle.check(recording(drawn))) == []
    [finding] = warned(check(Corruption(late(0.005), ("clocks",), (), {}), drawn))
    estimate, direction = re.findall(r"runs ([\d.]+) ± [\d.]+ ms (late|early)", finding.sentence)[0]
    assert direction == "late"
    assert 3.0 < float(estimate) < 7.0


@pytest.mark.parametrize("seed", [3, 18])
def test_a_finger_without_torque_reading_has_no_torque_about_its_tip(seed: int) -> None:
    """This holds for any `reference`, because no torque was read about the object's origin."""
    drawn = draw(seed, **{**SHORT, "frame": "world", "contact": "point"})
    tables = {name: {k: v for k, v in one.items() if k != "torque_z"} for name, one in drawn.tables.items()}
    wrench = drawn.metadata["wrench"] | {"reference": "object"}
    assert warned(trundle.check(trundle.Recording(drawn.metadata | {"wrench": wrench}, tables))) == []


def test_the_precontact_interval_may_start_before_the_table() -> None:
    drawn = draw(SHORT_SEED, **{**SHORT, "frame": "sensor", "raw": True})
    start, _ = drawn.metadata["wrench"]["precontact"]
    begun = {name: {k: v[10:] for k, v in one.items()} for name, one in drawn.tables.items()}
    assert min(one["t"][0] for one in begun.values()) > start
    trundle.Recording(drawn.metadata, begun)
    wrench = drawn.metadata["wrench"] | {"precontact": [-2.0, -1.0]}
    with pytest.raises(trundle.TrundleError, match=r"contains 0 wrench readings of .*, which lasts from"):
        trundle.Recording(drawn.metadata | {"wrench": wrench}, begun)


def test_runs_of_lost_poses_have_no_findings() -> None:
    """Runs of 0.15 s on average at random times; the longest one is not special."""
    clean, rng = short("sensor"), np.random.default_rng(4)
    tables = deepcopy(clean.tables)
    for columns in tables.values():
        poses = np.flatnonzero(~np.isnan(columns["object_x"]))
        changes = np.cumsum(rng.geometric([1 / 45, 1 / 15] * 40, (80,)))
        lost = poses[np.searchsorted(changes, np.arange(len(poses))) % 2 == 1]
        for name in columns:
            if name.startswith(("object", "gripper")):
                columns[name][lost] = np.nan
        some = ~(np.isnan(columns["object_x"]) & np.isnan(columns["force_x"]))
        columns.update({name: values[some] for name, values in columns.items()})
    findings = trundle.check(trundle.Recording(clean.metadata, tables))
    assert [finding for finding in warned(findings) if finding.kind == "gaps"] == []


@pytest.mark.slow
@pytest.mark.parametrize("corruption", CORRUPTIONS.values(), ids=CORRUPTIONS.keys())
def test_each_corruption_is_found_in_most_recordings(corruption: Corruption) -> None:
    drawn = [full(FIRST + 100 + k, key(corruption)) for k in range(EACH)]
    found = [corruption.found(check(corruption, one)) for one in drawn]
    assert sum(found) >= corruption.hits * EACH, found


@pytest.mark.slow
def test_clean_recordings_with_varied_instruments_have_no_findings() -> None:
    findings = {seed: warned(trundle.check(recording(draw(seed)))) for seed in range(FIRST, FIRST + CLEAN)}
    false = {seed: found for seed, found in findings.items() if found}
    assert len(false) <= 0.02 * CLEAN, false
