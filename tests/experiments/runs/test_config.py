"""The file of a run: invalid settings are refused in one sentence without output."""

from pathlib import Path

import pytest

from trundle.cli import main
from trundle.experiments.runs.config import read

ROOT = Path(__file__).parents[3]
LEAST = 'format = "trundle-run/1"\nenvironment = "trundle/PushAround-v0"\n'


def written(folder: Path, text: str) -> Path:
    path = folder / "run.toml"
    path.write_text(text, encoding="utf-8")
    return path


def test_a_minimal_file_is_valid(tmp_path: Path) -> None:
    settings = read(written(tmp_path, LEAST))
    assert (settings.seed, settings.episodes, settings.recording, settings.model) == (0, 1, "csv", None)


@pytest.mark.parametrize("name", ["run.toml", "run_friction.toml"])
def test_the_supplied_files_are_valid(name: str) -> None:
    settings = read(ROOT / "configs" / "experiments" / name)
    assert settings.environment == "trundle/PushAround-v0"
    assert settings.arguments["hidden"] == "locked"


def test_versions_and_levels_are_valid(tmp_path: Path) -> None:
    settings = read(written(tmp_path, LEAST.replace("PushAround-v0", "PushAroundHard-v1")))
    assert settings.environment == "trundle/PushAroundHard-v1"


def test_the_path_of_a_model_is_relative_to_the_file(tmp_path: Path) -> None:
    body = "footprint = [[-0.6, -0.4], [0.6, -0.4], [0.6, 0.4]]\nmass = {}\n"
    model = tmp_path / "first.toml"
    path = written(tmp_path, f'{LEAST}[agent]\nmodel = "first.toml"\n')
    plain = []
    for mass in (20.0, 30.0):
        model.write_text('format = "trundle-model/1"\n[body]\n' + body.format(mass), encoding="utf-8")
        plain.append(read(path).plain())
    assert plain[0] != plain[1]
    assert "mass = 30.0" in plain[1]["model"]


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", 'format = "trundle-run/1"'),
        ('format = "trundle-run/1"\n', "`environment` is missing"),
        (LEAST + "sead = 1\n", "unknown key `sead`; did you mean `seed`"),
        (LEAST + "seed = -1\n", "seed = -1"),
        (LEAST + "seed = true\n", "`seed` = True; it is a whole number"),
        (LEAST + "episodes = 0\n", "episodes = 0"),
        (LEAST + 'episodes = "3"\n', "`episodes` = '3'; it is a whole number"),
        (LEAST + 'recording = "xlsx"\n', "parquet"),
        (LEAST + "[arguments]\nhiden = 'locked'\n", "hiden"),
        (LEAST + "[arguments]\nhidden = 'somewhere'\n", "hidden"),
        (LEAST + "[arguments]\nhorizon = 0\n", "horizon"),
        (LEAST + "[arguments]\naction = 'push'\n", "wrench"),
        (LEAST + "[agent]\npusch = 1\n", "pusch"),
        (LEAST + "[agent]\npush = 0.01\n", "push = 0.01"),
        (LEAST + "[agent]\ndiagnose = 'false'\n", "`agent.diagnose` = 'false'; it is true or false"),
        (LEAST + "[agent]\npushes = 1.5\n", "`agent.pushes` = 1.5; it is a whole number"),
        (LEAST + "[agent]\nmodel = 3\n", "`agent.model` = 3; it is a string"),
        (LEAST + "[agent]\nmodel = 'nowhere.toml'\n", "nowhere.toml"),
        (LEAST + "[agent]\nmass = -5.0\n", "mass"),
        (LEAST + "[agent]\nenv = 'x'\n", "env"),
        (LEAST + "[agent]\nseed = -1\n", "seed = -1"),
        (LEAST + "[agent]\nstarts = 1000000\n", "starts = 1000000"),
        (LEAST.replace("Around", "Sofa"), "PushSofa"),
        ("format = ", "run.toml"),
    ],
)
def test_invalid_arguments_are_refused(
    text: str, words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = written(tmp_path, text)
    assert main(["run", str(path), "--out", str(tmp_path / "out")]) == 2
    complaint = capsys.readouterr().err
    assert words in complaint and "run.toml" in complaint
    assert not (tmp_path / "out").exists()


def test_a_missing_file_is_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["run", str(tmp_path / "none.toml"), "--out", str(tmp_path / "out")]) == 2
    assert "none.toml" in capsys.readouterr().err
