"""Draw the figures of docs/plots.md.

    python examples/plots.py docs/images

It simulates the demo, diagnoses it, and fits and samples the model that the diagnosis finds.
"""

from __future__ import annotations

import argparse
from pathlib import Path

import trundle

SCENARIO = Path(__file__).resolve().parents[1] / "configs" / "experiments" / "demo.toml"
DPI = 80


def main(out: Path) -> None:
    recording = trundle.simulate(SCENARIO)
    found = trundle.diagnose(recording)
    model = found.model.freed()
    fitted = trundle.fit(recording, model)
    posterior = trundle.sample(recording, model, starts=1)
    draw(out, recording, found, fitted, posterior)


def draw(
    out: Path,
    recording: trundle.Recording,
    found: trundle.Diagnosis,
    fitted: trundle.Fit,
    posterior: trundle.Posterior,
) -> None:
    figures = {
        "recording": trundle.plots.recording(recording, "episode_03"),
        "diagnosis": found.plot(),
        "residual": trundle.plots.residual(found, episodes=["episode_03", "episode_06"]),
        "fit": trundle.plots.fit(fitted, recording, ["episode_06", "episode_07", "episode_00"]),
        "posterior": trundle.plots.posterior(
            posterior, ["body.mass", "coulomb_friction.x", "coulomb_friction.y", "coulomb_friction.force"]
        ),
    }
    for name, figure in figures.items():
        figure.savefig(out / f"plots_{name}.png", dpi=DPI, metadata={"Software": None})


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description="Draw the figures of docs/plots.md.")
    parser.add_argument("out", type=Path, help="folder of the figures")
    main(parser.parse_args().out)
