"""`trundle.check` on clean and corrupted recordings of joints."""

from __future__ import annotations

import re
from functools import cache
from pathlib import Path

import numpy as np
import pytest

import trundle
from tests.command import trundle as command
from tests.joints.corruptions import CORRUPTIONS
from tests.joints.simulated import Columns, measured, motions, recording


@cache
def clean(joints: int) -> list[Columns]:
    """Return the episodes of one arm at 200 Hz."""
    rng = np.random.default_rng(1)
    return [measured(episode, rng) for episode in next(motions(1, joints, seed=4))]


def test_clean_recordings_have_no_findings() -> None:
    found = []
    for joints, count in ((1, 40), (2, 20)):
        rng = np.random.default_rng(joints)
        for case, episodes in enumerate(motions(count, joints, seed=50 + joints)):
            stride, noise = int(rng.choice([2, 5, 10, 20])), 10.0 ** rng.uniform(-5.0, -3.3)
            made = recording([measured(episode, rng, stride, noise) for episode in episodes])
            found += [(joints, case, str(finding)) for finding in trundle.check(made)]
    assert found == []


@pytest.mark.parametrize("name", CORRUPTIONS)
def test_a_mistake_has_one_finding(name: str) -> None:
    corruption = CORRUPTIONS[name]
    tables = []
    for episode in clean(corruption.joints):
        copied = {column: values.copy() for column, values in episode.items()}
        tables.append(corruption.change(copied) or copied)
    findings = trundle.check(recording(tables, **corruption.metadata))
    assert [finding.kind for finding in findings] == [corruption.kind], findings
    assert re.search(corruption.words, findings[0].sentence), findings
    assert findings[0].remedy


def test_a_stated_delay_is_no_finding() -> None:
    t = clean(2)[0]["t"]
    tables = [{**episode, "v_elbow": np.interp(t - 0.02, t, episode["v_elbow"])} for episode in clean(2)]
    assert not trundle.check(recording(tables, delay={"v": {"elbow": 0.02}}))


def test_the_gain_of_an_axis_is_compared_with_its_known_inertia() -> None:
    free = trundle.check(recording(clean(1))).errors
    assert free == []
    made = recording(clean(1))
    mechanism = {**made.metadata["mechanism"], "inertia": 1.0}
    wrong = trundle.JointRecording({**made.metadata, "mechanism": mechanism}, made)
    (finding,) = trundle.check(wrong)
    ratio = float(re.findall(r"is (\S+) times what the stated inertia", finding.sentence)[0])
    assert finding.kind == "units"
    assert 0.01 < ratio < 0.5
    right = trundle.JointRecording({**made.metadata, "mechanism": {**mechanism, "inertia": ratio}}, made)
    assert not trundle.check(right)


def test_the_command_prints_the_findings(tmp_path: Path) -> None:
    tables = [{**episode, "effort_shoulder": -episode["effort_shoulder"]} for episode in clean(1)]
    recording(tables, split={"held_out": ["episode_02"]}).write(tmp_path / "run")
    ran = command(tmp_path, "check", "run", "--strict")
    assert ran.returncode == 2, ran.stderr
    assert "error (sign): the effort of shoulder opposes its motion" in ran.stdout
    assert "negative [effort] gain" in ran.stdout
