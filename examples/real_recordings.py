"""Diagnose three published data sets of real machines: the numbers of docs/real-recordings.md.

    python examples/real_recordings.py DATA

DATA contains `emps/`, `cmu-planar-push/` and `pneumatic-seal/` (sources: docs/real-recordings.md).
"""

from __future__ import annotations

import argparse
import copy
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.signal import butter, filtfilt, periodogram

import trundle
from trundle import importers

Floats = NDArray[np.float64]
CONFIGS = Path(__file__).resolve().parents[1] / "configs"
MODELS = CONFIGS / "models"
LATER, EARLIER = ("exp3_3", "exp3_4", "exp4_1"), ("exp3_1", "exp3_2")
SEALS = [f"{kind}_{bar}bar" for kind in ("O-ring", "X-ring257") for bar in (1, 3, 5, 7)]
ALL_PRESSURES = ("seal_o_ring", "seal_x_ring")
LOGS = {"exp3_1": 0.38, "exp3_2": 0.36, "exp3_3": 0.78, "exp3_4": 0.65, "exp4_1": 0.76}
"""Median force of straight sliding, N, as returned by `straight_sliding_force`."""


def emps(data: Path) -> trundle.Recording:
    """Return the recording of the EMPS axis."""
    return import_source(data / "emps", "emps")


def pushes(data: Path) -> dict[str, trundle.Recording]:
    """Return the recording of each file of single pushes, by file name."""
    files = sorted((data / "cmu-planar-push" / "pushes").glob("*.txt"))
    return {file.stem: import_source(file, "cmu-planar-push") for file in files}


def logs(data: Path, earlier: bool) -> trundle.Recording:
    """Return the recording of the later or of the earlier continuous logs."""
    map_file = CONFIGS / "import" / "cmu_earlier.toml" if earlier else None
    return import_source(data / "cmu-planar-push" / "timeseries", "cmu-planar-push", map_file)


def seal(data: Path, name: str) -> trundle.Recording:
    """Return the recording of a seal, at one pressure (`SEALS`) or at all (`ALL_PRESSURES`)."""
    folder = data / "pneumatic-seal"
    if name in ALL_PRESSURES:
        return import_source(folder, "pneumatic-seal", CONFIGS / "import" / f"{name}.toml")
    return import_source(folder / f"{name}.csv", "pneumatic-seal")


def import_source(source: Path, layout: str, map_file: Path | None = None) -> trundle.Recording:
    """Import a source without writing it to disk."""
    data = importers.read(source, layout, map_file)
    return trundle.Recording(data.metadata, data.episodes)


def with_held_out(recording: trundle.Recording, episode: str) -> trundle.Recording:
    """Return the recording with only this episode held out."""
    metadata = copy.deepcopy(recording.metadata)
    metadata["split"] = {"held_out": [episode]}
    return trundle.Recording(metadata, recording.episodes)


def wrench_r2(series: dict[str, Any], corners: Sequence[Sequence[float]], which: str = "before") -> float:
    """Return R² of the wrench that a model requires for the recorded motion, on held-out episodes.

    Parameters
    ----------
    series : dict
        The series of a diagnosis.
    corners : (3, 2)
        Corners of the pushed triangle, m, object frame.
    which : str
        "before": the nominal model, refitted; "after": with the named effects.

    Returns
    -------
    float
        1 minus the ratio of the mean squares of (required − recorded) and recorded. Moments are about the
        triangle's centroid and divided by its radius of gyration.
    """
    held_out = [e["wrench"] for e in series["episodes"] if e["held_out"] and e["wrench"]]
    recorded, required = (
        np.concatenate([about_centroid(np.array(w[name]), np.array(corners)) for w in held_out])
        for name in ("recorded", which)
    )
    return float(1.0 - np.sum((required - recorded) ** 2) / np.sum(recorded**2))


def about_centroid(wrench: Floats, corners: Floats) -> Floats:
    """Return wrenches (n, 3) about a triangle's centroid, N; moments divided by the radius of gyration."""
    x, y = corners.mean(axis=0)
    sides = corners - np.roll(corners, 1, axis=0)
    gyration = np.sqrt(np.sum(sides**2) / 36.0)
    moment = wrench[:, 2] - x * wrench[:, 1] + y * wrench[:, 0]
    return np.column_stack([wrench[:, :2], moment / gyration])


def compare_under_body(recording: trundle.Recording) -> tuple[float, float, float]:
    """Return the held-out R² of viscous and of dry friction under the body, and the dry friction, N."""
    corners = recording.metadata["object"]["footprint"]
    viscous = trundle.diagnose(recording, MODELS / "drag_under_body.toml")
    dry = trundle.diagnose(recording, MODELS / "friction_under_body.toml")
    friction = dry.answer["nominal"]["before"]["support_friction.force"]["mean"]
    return wrench_r2(viscous.series, corners), wrench_r2(dry.series, corners), friction


def straight_sliding_force(recording: trundle.Recording) -> dict[str, float]:
    """Return the median force of straight sliding by episode, N; dry friction is then largest."""
    series = trundle.diagnose(recording, MODELS / "friction_under_body.toml").series
    sizes = {
        episode["name"]: [
            np.hypot(*np.array(episode["wrench"][key])[:, :2].T) for key in ("before", "recorded")
        ]
        for episode in series["episodes"]
    }
    most = max(required.max() for required, _ in sizes.values())
    return {name: float(np.median(seen[required > 0.95 * most])) for name, (required, seen) in sizes.items()}


def default_diagnosis(recording: trundle.Recording) -> str:
    """Return the answer of a diagnosis of the paper's model and its held-out R² as text."""
    corners = recording.metadata["object"]["footprint"]
    answer = trundle.diagnose(recording)
    r2 = [wrench_r2(answer.series, corners, which) for which in ("before", "after")]
    return f"R² {r2[0]:.3f} -> {r2[1]:.3f}, {answer.verdict}: " + "; ".join(
        effect["statement"] for effect in answer.answer["missing"]
    )


def by_direction(recording: trundle.Recording) -> list[float]:
    """Return mass, viscous friction, dry friction and the viscous difference by direction, SI units."""
    summary = trundle.fit(recording, MODELS / "rail_directional.toml").summary
    return [parameter["mean"] for parameter in summary["parameters"]]


def missing_force(
    recording: trundle.Recording, episode: str, fitted: Sequence[float], delay: float = 0.0
) -> dict[str, Floats]:
    """Return the force of the drive below 60 Hz that the direction-dependent model does not explain.

    Parameters
    ----------
    recording : Recording
        The recording of the EMPS axis.
    episode : str
    fitted : sequence of float
        Result of `by_direction`.
    delay : float
        Assumed delay of the force after its command, s.

    Returns
    -------
    dict
        ``t`` s, ``x`` m, ``v`` m/s and ``missing`` N, 1 kHz.
    """
    mass, mu, force, difference = fitted
    table = recording.episodes[episode]
    t = table["t"]
    low = butter(4, 60.0 * 2.0 * float(np.median(np.diff(t))))
    x = filtfilt(*low, table["object_x"])
    drive = np.interp(t - delay, t, filtfilt(*low, table["force_x"]))
    v = np.gradient(x, t)
    required = mass * np.gradient(v, t) + mu * v + difference * np.abs(v) + force * np.tanh(v / 2e-3)
    inside = slice(200, -200)
    return {"t": t[inside], "x": x[inside], "v": v[inside], "missing": (drive - required)[inside]}


def ripple(residual: dict[str, Floats], speed: float) -> tuple[Floats, Floats]:
    """Return position (m) and missing force without its slow part (N) of the first run at a speed (m/s)."""
    near = np.flatnonzero(np.abs(residual["v"] - speed) < 0.05 * speed)
    runs = np.split(near, np.flatnonzero(np.diff(near) > 1) + 1)
    # Without the ends, where the axis still oscillates.
    run = next(run[100:-30] for run in runs if len(run) > 350)
    x, missing = residual["x"][run], residual["missing"][run]
    return x, missing - np.polyval(np.polyfit(x - x[0], missing, 3), x - x[0])


def spectrum(force: Floats, speed: float) -> tuple[Floats, Floats]:
    """Return spatial frequencies (1/m) and powers of a force at 1 kHz and constant speed (m/s)."""
    frequency, power = periodogram(force * np.hanning(len(force)), 1e3, nfft=8192)
    return frequency / speed, power


def print_missing_force(data: Path) -> None:
    """Print the missing force of the axis: by speed, its period, and its dependence on a delay."""
    recording = emps(data)
    fitted = by_direction(recording)
    residual = missing_force(recording, "episode_00", fitted)
    slow = np.abs(residual["v"]) < 0.01
    for where, chosen in (("below", slow), ("above", ~slow)):
        print(f"missing force {where} 0.01 m/s: {np.std(residual['missing'][chosen]):.2f} N rms")
    late = missing_force(recording, "episode_00", fitted, 0.8e-3)
    print(
        f"maximum with a delay of 0.8 ms: {np.max(np.abs(late['missing'])):.1f} N,",
        end=" ",
    )
    print(f"at {late['v'][np.argmax(np.abs(late['missing']))]:.3f} m/s")
    for speed in (0.083, 0.125):
        force = ripple(residual, speed)[1]
        cycles, power = spectrum(force, speed)
        period = 1e3 / cycles[np.argmax(power)]
        print(f"ripple at {speed} m/s: {np.std(force):.2f} N rms, period {period:.2f} mm")
    for episode in recording.episodes:
        rms = {
            ms: np.std(missing_force(recording, episode, fitted, 1e-3 * ms)["missing"])
            for ms in (0.0, 0.4, 0.8, 1.2)
        }
        print(f"{episode}: missing force by delay:", end=" ")
        print(", ".join(f"{ms} ms: {value:.2f} N" for ms, value in rms.items()))


def print_emps(data: Path) -> None:
    """Print parameters and held-out errors of the axis for four models."""
    recording = emps(data)
    for name in ("rail_viscous", "rail_dry_bias", "rail_dry_slope", "rail_directional"):
        summary = trundle.fit(recording, MODELS / f"{name}.toml").summary
        held_out = summary["held_out"]
        print(
            f"{name}: open loop {1e3 * held_out['position_rmse']:.1f} mm,",
            f"1 s windows {1e3 * held_out['window_position_rmse']:.2f} mm;",
            ", ".join(
                f"{p['name']} {p['mean']:.4g} ± {p['sd']:.2g} {p['unit']}" for p in summary["parameters"]
            ),
        )
    answer = trundle.diagnose(recording, MODELS / "rail_viscous.toml")
    print(f"diagnosis: {answer.verdict}:", " ".join(e["statement"] for e in answer.answer["missing"]))


def print_pushes(data: Path) -> None:
    """Print R² of viscous and dry friction on held-out pushes."""
    rows = []
    for name, recording in pushes(data).items():
        rows.append(compare_under_body(recording))
        print(f"{name}: under the body, viscous -> dry: R² {rows[-1][0]:.3f} -> {rows[-1][1]:.3f},", end=" ")
        print(f"{rows[-1][2]:.2f} N\n    default model: {default_diagnosis(recording)}")
    mean = np.mean(rows, axis=0)
    print(f"mean of {len(rows)} sets: {mean[0]:.3f} -> {mean[1]:.3f}, {mean[2]:.2f} N")


def print_logs(data: Path) -> None:
    """Print R² of viscous and dry friction on each log, held out in turn."""
    for earlier in (False, True):
        recording = logs(data, earlier)
        print("force of straight sliding:", end=" ")
        print(", ".join(f"{log} {force:.2f} N" for log, force in straight_sliding_force(recording).items()))
        for log in recording.episodes:
            split = with_held_out(recording, log)
            viscous, dry, friction = compare_under_body(split)
            print(f"{log}: under the body, viscous -> dry: R² {viscous:.3f} -> {dry:.3f}, {friction:.2f} N")
            print(f"    default model: {default_diagnosis(split)}")


METRICS = {
    "position_rmse": ("open loop", "mm", 1e3),
    "window_position_rmse": ("1 s ahead", "mm", 1e3),
    "heading_rmse": ("heading", "mrad", 1e3),
    "force_rmse": ("force", "N", 1.0),
    "torque_rmse": ("moment", "N·mm", 1e3),
}
"""Held-out metrics of the table by their key in `diagnosis.json`: label, unit, units per SI unit."""


@dataclass(frozen=True)
class Case:
    """A recording with known results.

    Attributes
    ----------
    name : str
    known : str
        Result of the publication, or of the force alone if there is none.
    recording : Recording
    model : Path, optional
        Nominal model; the paper's by default.
    """

    name: str
    known: str
    recording: trundle.Recording
    model: Path | None = None


def cases(data: Path) -> Iterator[Case]:
    """Yield all recordings of the folder `data`."""
    yield Case(
        "EMPS",
        "dry 20.4 N and offset -3.2 N, or friction by direction",
        emps(data),
        MODELS / "rail_viscous.toml",
    )
    for name, recording in pushes(data).items():
        yield Case(name, "dry 4.2 N (pull test)", recording)
    for earlier in (False, True):
        recording = logs(data, earlier)
        for log in recording.episodes:
            yield Case(
                f"{log} held out", f"dry, {LOGS[log]} N sliding straight", with_held_out(recording, log)
            )
    for name in (*SEALS, *ALL_PRESSURES):
        yield Case(name, "dry, grows with pressure; offset", seal(data, name))


def format_answer(answer: Mapping[str, Any]) -> str:
    """Format verdict, effects with probabilities, ties, and immaterial effects with their explained share."""
    effects = ", ".join(f"{effect['effect']} {effect['probability']:.2f}" for effect in answer["missing"])
    ties = "; ".join(" = ".join(tie) for tie in answer["tied"])
    immaterial = ", ".join(
        f"{effect['effect']} {effect['explains'] or 0:.2f}" for effect in answer["immaterial"]
    )
    text = ": ".join(part for part in (answer["verdict"], effects) if part)
    text += f" (tied: {ties})" if ties else ""
    return text + (f" (immaterial: {immaterial})" if immaterial else "")


def held_out_metrics(answer: Mapping[str, Any]) -> tuple[list[str], list[str]]:
    """Return the held-out metrics before -> after as text, and the labels of those that get worse."""
    metrics, worse = [], []
    both = answer["fit"]["held_out"]
    for key, (label, unit, factor) in METRICS.items():
        before, after = both["before"][key], both["after"][key]
        if before is None or after is None:
            continue
        metrics.append(f"{label} {factor * before:.3g} -> {factor * after:.3g} {unit}")
        if after > before:
            worse.append(label)
    return metrics, worse


def format_periods(answer: Mapping[str, Any]) -> str:
    """Format the periods of the residual over position, mm, with the amplitude of the force, N."""
    periods = [period for period in answer["residual"]["periods"] if period["of"] == "position"]
    return ", ".join(f"{1e3 * p['period']:.2f} mm ({p['amplitude']:.2f} N)" for p in periods)


def print_table(data: Path) -> None:
    """Print a row for each recording, then the answers with held-out metrics that get worse."""
    rows, worse = [], []
    for case in cases(data):
        start = time.perf_counter()
        answer = trundle.diagnose(case.recording, case.model).answer
        seconds = time.perf_counter() - start
        metrics, got_worse = held_out_metrics(answer)
        rows.append(
            (
                case.name,
                case.known,
                format_answer(answer),
                "; ".join(metrics),
                format_periods(answer),
                f"{seconds:.0f}",
            )
        )
        print("| " + " | ".join(rows[-1]) + " |", flush=True)
        if got_worse:
            worse.append(f"{case.name}: {', '.join(got_worse)}")
    print("held-out metrics that get worse:", "; ".join(worse) or "none")


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("data", type=Path, help="folder with emps/, cmu-planar-push/ and pneumatic-seal/")
    folder = parser.parse_args().data
    print_table(folder)
    for print_part in (print_emps, print_missing_force, print_pushes, print_logs):
        print_part(folder)
