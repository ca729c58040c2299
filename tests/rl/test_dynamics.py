"""Training of dynamics models. Needs the extra [rl]."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch

from trundle.cli import main
from trundle.experiments.training.config import FORMAT, Dynamics, read
from trundle.experiments.training.dynamics import fit, run
from trundle.experiments.training.dynamics.errors import prediction_errors
from trundle.experiments.training.dynamics.model import About, DynamicsModel, load
from trundle.experiments.training.dynamics.motion import INPUTS, SHAPE, Motion, motion_of, shape_of
from trundle.settings import parse_format

TINY = """
format = "trundle-train/1"
algorithm = "Dynamics"
env = "trundle/PushPoseHard-v1"
seeds = [1]
n_timesteps = 4096
n_steps = 64
n_envs = 32
networks = 2
n_updates = 4
units = 6
rollout = 5
batch_size = 8

[policy_kwargs]
net_arch = [8]

[evaluation]
every = 2
episodes = 24
"""


def written(folder: Path, text: str = TINY) -> Path:
    path = folder / "tiny.toml"
    path.write_text(text)
    return path


def settings_of(path: Path) -> Dynamics:
    settings = read(path)
    assert isinstance(settings, Dynamics)
    return settings


def results(folder: Path) -> dict[str, bytes]:
    return {file.name: file.read_bytes() for file in (folder / "dynamics").iterdir()}


@pytest.mark.parametrize("steps", [0, 10])
def test_a_network_in_numpy_predicts_like_that_of_torch(steps: int, tmp_path: Path) -> None:
    settings = settings_of(written(tmp_path))
    episodes = run.episodes_of(settings, 5, 6)
    data = fit.Data.of(episodes)
    scales = fit.scales_of(data)
    predictor = fit.Predictor(settings)
    about = About("tiny", "0", 1, 0, 0, settings.env, {}, 0.05)
    model = DynamicsModel(about, scales, [predictor.network()])
    motion, shape = motion_of(episodes.observations), shape_of(episodes.observations[0])
    context = model.start(6)
    for step in range(steps):
        context = model.remember(context, Motion(motion.inputs[step], motion.targets[step]), shape)
    wrenches = np.stack([motion.inputs[steps, :, 3:6], motion.inputs[steps, :, 6:]], axis=1)
    # At a heading of zero the axes of the world are those of the object.
    start = np.zeros((6, 3)), motion.inputs[steps, :, :3]
    states = model.rollout(context, shape, start, wrenches)[0, :, 0]
    seen = np.concatenate([data.inputs, np.broadcast_to(shape, (*data.inputs.shape[:2], SHAPE))], axis=2)
    seen = (np.concatenate([seen, data.targets[..., :3]], axis=2) - scales.mean) / scales.deviation
    with torch.no_grad():
        values = torch.as_tensor(seen, dtype=torch.float32)
        contexts = predictor.contexts(values)[steps]
        outputs = predictor(torch.cat([values[steps, :, : INPUTS + SHAPE], contexts], dim=1)).numpy()
    change, difference = outputs[:, :3] * scales.change, outputs[:, 3:] * scales.change
    assert np.allclose(states[:, :3], 0.05 * (start[1] + 0.5 * change + difference), atol=1e-5)
    assert np.allclose(states[:, 5], start[1][:, 2] + change[:, 2], atol=1e-5)


def test_a_network_learns_to_predict_and_to_adapt(tmp_path: Path) -> None:
    text = TINY.replace("n_updates = 4", "n_updates = 150").replace("units = 6", "units = 32")
    text = text.replace("net_arch = [8]", "net_arch = [32]").replace(
        "n_timesteps = 4096", "n_timesteps = 40_960"
    )
    text = text.replace("networks = 2", 'networks = 1\nlearning_rate = "lin_0.01"').replace(
        "every = 2", "every = 150"
    )
    path = written(tmp_path, text.replace("episodes = 24", "episodes = 128"))
    assert main(["train", str(path), "--out", str(tmp_path / "out"), "--quiet"]) == 0
    settings = settings_of(path)
    model = load(tmp_path / "out/dynamics/tiny-1.npz")
    episodes = run.evaluation_episodes(settings)
    untrained = DynamicsModel(model.about, model.scales, [fit.Predictor(settings).network()])
    before, unaware, aware = (
        prediction_errors(one, episodes, after)["distance"]
        for one, after in ((untrained, 1.0), (model, 0.0), (model, 1.0))
    )
    assert aware < 0.7 * before
    assert aware < 0.8 * unaware


def test_a_finished_training_is_not_repeated(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path, out = written(tmp_path), tmp_path / "out"
    line = ["train", str(path), "--out", str(out)]
    assert main(line) == 0
    first, kept = capsys.readouterr().out, results(out)
    report = r"tiny-1\.npz: predictions of 1 s after 1 s of motion are off by \d+\.\d cm and \d\.\d{3} rad"
    assert re.search(report, first)
    assert "2 with a memory (LSTM, 6 units)" in kept["tiny-1.md"].decode()
    assert main(line) == 0
    assert capsys.readouterr().out == first
    assert results(out) == kept
    path.write_text(path.read_text().replace("units = 6", "units = 5"))
    assert main(line) == 2
    assert "has other settings" in capsys.readouterr().err
    assert main([*line, "--device", "auto"]) == 2
    assert "trained on the cpu" in capsys.readouterr().err


def test_an_interrupted_training_ends_with_the_same_bytes(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = written(tmp_path)
    assert main(["train", str(path), "--out", str(tmp_path / "whole"), "--quiet"]) == 0
    fitted: list[int] = []

    def interrupted(*arguments: Any) -> Any:
        fitted.append(arguments[4])
        if len(fitted) == 2:
            raise KeyboardInterrupt
        return fit.fit(*arguments)

    monkeypatch.setattr(run, "fit", interrupted)
    table = parse_format(path, FORMAT)
    with pytest.raises(KeyboardInterrupt):
        run.train(path, table, 1, tmp_path / "parts", quiet=True)
    run.train(path, table, 1, tmp_path / "parts", quiet=True)
    assert fitted == [1_000_000, 1_000_001, 1_000_001]
    assert results(tmp_path / "whole") == results(tmp_path / "parts")


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("rollout = 5", "rollout = 64", "rollout = 64: must be less than n_steps = 64"),
        ("rollout = 5", "frame_stack = 2", "remove them"),
        ("units = 6", "unit = 6", "unknown key `unit`"),
    ],
)
def test_invalid_settings_are_refused(
    old: str, new: str, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tmp_path, TINY.replace(old, new))
    assert main(["train", str(path), "--out", str(tmp_path / "out")]) == 2
    assert message in capsys.readouterr().err
