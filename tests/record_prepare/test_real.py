"""Checks on real recordings, if present: no serious false alarms."""

from __future__ import annotations

from pathlib import Path

import trundle
from tests.conftest import RealData
from trundle.cli import main


def imported(layout: str, source: Path, out: Path) -> trundle.Recording:
    assert main(["import", str(source), "--from", layout, "--out", str(out), "--quiet"]) == 0
    return trundle.read(out)


def grave(recording: trundle.Recording) -> list[tuple[str, str | None]]:
    return [(f.kind, f.episode) for f in trundle.check(recording) if f.severity != "note"]


def test_the_rail_has_no_serious_findings(real_data: RealData, tmp_path: Path) -> None:
    recording = imported("emps", real_data("emps"), tmp_path / "emps")
    assert grave(recording) == []


def test_continuous_logs_have_no_serious_findings(real_data: RealData, tmp_path: Path) -> None:
    recording = imported("cmu-planar-push", real_data("cmu-planar-push/timeseries"), tmp_path / "logs")
    assert grave(recording) == []
    assert "mass" in {finding.kind for finding in trundle.check(recording)}  # quasi-static
    for episode in trundle.inspect(recording).episodes:
        # The tracker flickers, and in some logs loses the attitude for half a second.
        assert episode.counts.pose_outliers < 0.05 * episode.object.samples


def test_single_pushes_have_few_findings(real_data: RealData, tmp_path: Path) -> None:
    for source in sorted(real_data("cmu-planar-push/pushes").glob("*.txt")):
        recording = imported("cmu-planar-push", source, tmp_path / source.stem)
        # Some of them have a tare in contact and no other finding.
        assert {kind for kind, _ in grave(recording)} <= {"tare"}
