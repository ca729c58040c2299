"""The representation of every public object fits a screen and says the essentials."""

from __future__ import annotations

import functools
import inspect
import re
from collections.abc import Callable, Iterator
from html.parser import HTMLParser
from pathlib import Path
from types import ModuleType
from typing import Any

import gymnasium
import numpy as np
import pytest

import trundle
from tests.display.samples import answer, diagnosis, fit, model, recording
from trundle.design import DesignedPush
from trundle.display.card import MAX_LINES, MAX_WIDTH, Card, Table
from trundle.importers.guess.result import Question

CONFIGS = Path(__file__).resolve().parents[2] / "configs"


def design() -> trundle.Design:
    push = DesignedPush(
        grasp=(0.1, 0.2),
        direction=0.0,
        start=(0.0, 0.0, 0.0),
        profile="steady",
        force=10.0,
        torque=1.0,
        duration=2.0,
        knots=np.zeros((400, 4)),
        separation=3.0,
        cumulative=3.0,
        sentence="push " * 90,
    )
    models, answer = (model(), model()), {"long": "x" * 9999}
    return trundle.Design(
        ("a", "b"),
        (push,) * 40,
        (1.0, 2.0),
        0.0,
        0.9,
        None,
        "sentence " * 40,
        models,
        ("warning " * 40,),
        answer,
    )


def online() -> trundle.Online:
    found = trundle.Online(recording().metadata, starts=1)
    found.update(recording()["episode_00"])
    return found


def calibration() -> trundle.calibration.Calibration:
    line: Any = {
        "name": "mass",
        "rounds": 3,
        "cover_50": [0.5, 0.1, 0.9],
        "cover_90": [0.9, 0.7, 1.0],
        "uniform_p": 0.4,
        "histogram": [1] * 10,
        "mean_rank": 0.5,
    }
    return trundle.calibration.Calibration(
        {"name": "table", "method": "laplace", "parameters": [line] * 30}, [{}] * 999
    )


def map_guess() -> trundle.importers.MapGuess:
    question = Question("columns.object_x", "which column " * 40)
    return trundle.importers.MapGuess(Path("log.csv"), {}, [], [question] * 40)


def agent() -> trundle.AdaptiveAgent:
    env = gymnasium.make("trundle/LockedWheel-v0")
    found = trundle.AdaptiveAgent(env)
    found.predict(env.reset(seed=0)[0], episode_start=True)
    return found


def record(folder: Path = Path("unused")) -> Any:
    return trundle.Record(gymnasium.make("trundle/LockedWheel-v0"), folder)


def transitions() -> Any:
    rows = np.zeros((5000, 6))
    return trundle.baselines.Transitions(rows, rows[:, :3], np.full(5000, 0.1), rows)


def environment(kind: type) -> Any:
    return lambda: gymnasium.make(f"trundle/{kind.__name__}-v0").unwrapped


def mechanism(armature: float = 0.0) -> trundle.mechanism.Mechanism:
    text = f"""<mujoco><worldbody><body name="arm"><joint name="elbow" axis="0 1 0" armature="{armature}"/>
        <inertial pos="1 0 0" mass="2" diaginertia="1e-6 1e-6 1e-6"/></body></worldbody></mujoco>"""
    return trundle.mechanism.Mechanism.load(text, ["elbow"])


def mechanism_model() -> trundle.mechanism.MechanismModel:
    return trundle.mechanism.MechanismModel.from_toml(
        'format = "trundle-model/2"\n[mechanism]\naxis = "hinge"\njoints = ["arm"]\n'
        '[nominal]\n"damping:arm" = 0.1\n'
        '[[effect]]\nkind = "joint_dry_friction"\njoint = "arm"\neffort = 1.2\n'
    )


def bench() -> trundle.JointRecording:
    t = np.arange(0.0, 10.0, 0.01)
    q = np.sin(2.0 * t) + 0.5 * np.sin(3.1 * t)
    v = 2.0 * np.cos(2.0 * t) + 1.55 * np.cos(3.1 * t)
    a = -4.0 * np.sin(2.0 * t) - 4.805 * np.sin(3.1 * t)
    effort = 0.1 * a + 0.05 * v + 0.2 * np.sign(v)
    metadata = {
        "format": "trundle-recording/2",
        "name": "bench",
        "mechanism": {"axis": "hinge", "joints": ["arm"]},
    }
    episodes = {"swing": {"t": t, "q_arm": q, "effort_arm": effort}}
    return trundle.JointRecording(metadata, episodes)


@functools.cache
def joint_diagnosis() -> trundle.JointDiagnosis:
    return trundle.diagnose(bench(), check=False)


@functools.cache
def joint_design() -> trundle.JointDesign:
    return trundle.design("joint_dry_friction:arm", "joint_cogging:arm", recording=bench())


def joint_recording() -> trundle.JointRecording:
    joints = [f"joint_{k}" + "x" * 60 for k in range(30)]
    metadata: Any = {
        "format": "trundle-recording/2",
        "name": "arm",
        "mechanism": {"model": "arm.xml", "joints": joints},
    }
    columns = {f"{prefix}_{joint}": [0.0, 0.1, 0.2] for prefix in ("q", "effort") for joint in joints}
    episodes = {f"episode_{k:02}": {"t": [0.0, 0.1, 0.2], **columns} for k in range(30)}
    return trundle.JointRecording(metadata, episodes, {"arm.xml": "<mujoco/>"})


MAKE: dict[str, Callable[[], Any]] = {
    "AdaptiveAgent": agent,
    "AgentSettings": lambda: trundle.AgentSettings(planner={"samples": 64}),
    "Belief": lambda: agent().beliefs[0],
    "Design": design,
    "DesignedPush": lambda: design().pushes[0],
    "Diagnosis": diagnosis,
    "Episode": lambda: recording()["episode_00"],
    "Finding": lambda: trundle.Finding("sign", "error", "wrong " * 99, "turn it\nround " * 99, "episode_00"),
    "Findings": lambda: trundle.Findings([trundle.Finding("a", "note", "x" * 300, "y" * 300)] * 99),
    "Fit": fit,
    "JointEpisode": lambda: joint_recording()["episode_00"],
    "JointDesign": joint_design,
    "JointDiagnosis": joint_diagnosis,
    "Mechanism": mechanism,
    "Regressors": lambda: mechanism().regressors(*np.zeros((3, 50, 1))),
    "EffortDrive": lambda: trundle.mechanism.EffortDrive(np.arange(500.0), np.zeros((500, 1))),
    "PositionDrive": lambda: trundle.mechanism.PositionDrive([0.0], [[1.0]], [30.0], [2.0]),
    "SwitchedDrive": lambda: trundle.mechanism.SwitchedDrive(MAKE["EffortDrive"](), [0.0], [[1.0]]),
    "Transmission": lambda: trundle.mechanism.Transmission("elbow", on_drive=True, gap=0.02),
    "SplitModel": lambda: trundle.mechanism.split_model(mechanism(0.1), [MAKE["Transmission"]()]),
    "Payload": lambda: trundle.mechanism.Payload("arm", 0.5, (0.0, 0.0, 0.1)),
    "JointEffect": lambda: mechanism_model().effect[0],
    "MechanismModel": lambda: mechanism_model(),
    "MechanismTable": lambda: mechanism_model().mechanism,
    "JointRecording": joint_recording,
    "JointSummary": lambda: trundle.inspect(joint_recording()),
    "MapGuess": map_guess,
    "Model": lambda: model(""),
    "Online": online,
    "Planner": lambda: trundle.Planner([-1, -1, -1], [1, 1, 1]),
    "Posterior": lambda: trundle.sample(recording(), draws=10, starts=1),
    "Prediction": lambda: trundle.predict(recording(), model()),
    "Profile": lambda: trundle.Profile(
        "m", "kg", np.arange(99.0), np.arange(99.0), (1.0, None), "at least", (), 1.0, 0.1
    ),
    "Record": record,
    "Recording": recording,
    "RecordingSummary": lambda: trundle.inspect(recording()),
    "Stream": lambda: recording()["episode_00"].wrench,
    "Calibration": calibration,
    "Laws": lambda: trundle.export.Laws(model()),
    "Object": lambda: trundle.objects.read(CONFIGS / "objects/office_table.toml"),
    "Observation": lambda: trundle.envs.Observation(np.zeros((64, 20))),
    "Transitions": transitions,
    "PhysicalModel": lambda: trundle.baselines.PhysicalModel(model()),
    "LinearRegression": trundle.baselines.LinearRegression,
    "LocallyWeightedRegression": trundle.baselines.LocallyWeightedRegression,
    "Oracle": lambda: trundle.envs.Oracle(gymnasium.make("trundle/LockedWheel-v0")),
    "VectorOracle": lambda: trundle.envs.VectorOracle(_batch("LockedWheel")),
    "Push": environment(trundle.envs.LockedWheel),
    "PushGoal": environment(trundle.envs.PushPoseGoal),
    "PushVec": lambda: _batch("LockedWheel"),
    "PushGoalVec": lambda: _batch("PushPoseGoal"),
    **{kind.__name__: environment(kind) for kind in trundle.envs.FLAT},
    **{
        f"Push{task}Goal": environment(getattr(trundle.envs, f"Push{task}Goal"))
        for task in ("Pose", "Path", "Around", "Door")
    },
}
"""An instance of every public class, with much content."""


def _batch(name: str) -> Any:
    return gymnasium.make_vec(f"trundle/{name}-v0", num_envs=64, vectorization_mode="vector_entry_point")


def public_classes() -> Iterator[type]:
    """Yield the classes in `trundle.__all__` and in that of its submodules, exceptions omitted."""
    found = [getattr(trundle, name) for name in trundle.__all__]
    found += [getattr(one, name) for one in found if isinstance(one, ModuleType) for name in one.__all__]
    yield from {one for one in found if inspect.isclass(one) and not issubclass(one, Exception)}


def test_an_instance_of_every_public_class_is_tested() -> None:
    assert {one.__name__ for one in public_classes()} <= MAKE.keys() | {"Imported", "Importer"}


@pytest.mark.parametrize("name", MAKE)
def test_the_text_fits_a_screen(name: str) -> None:
    lines = repr(MAKE[name]()).splitlines()
    assert 1 <= len(lines) <= MAX_LINES
    assert max(map(len, lines)) <= MAX_WIDTH


@pytest.mark.parametrize(
    "name", ["Diagnosis", "Fit", "Model", "Posterior", "Prediction", "Recording", "Findings"]
)
def test_the_html_is_compact_and_balanced(name: str) -> None:
    html = MAKE[name]()._repr_html_()
    assert len(html) < 80_000
    assert balanced(html)


class Tags(HTMLParser):
    """Open elements; an element that closes another one is an error."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []

    def handle_starttag(self, tag: str, attrs: Any) -> None:
        assert tag in {"div", "strong", "table", "thead", "tbody", "tr", "th", "td"}
        self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def balanced(html: str) -> bool:
    tags = Tags()
    tags.feed(html)
    tags.close()
    return not tags.open


def test_fields_without_a_representation_are_left_out() -> None:
    text = repr(MAKE["SplitModel"]())
    assert "transmissions" in text
    assert "compiled" not in text


def test_all_text_is_escaped() -> None:
    attack = "<script>alert('&')</script>"
    table = Table((attack, attack), [(attack, attack)])
    html = Card(attack, [(attack, attack)], table).html()
    assert "<script" not in html and html.count("&lt;script&gt;") == 7
    assert attack not in recording(name=attack)._repr_html_()
    assert balanced(diagnosis(answer() | {"recording": attack})._repr_html_())


def test_html_has_no_colours_of_its_own() -> None:
    """Text and background are those of the notebook, light or dark."""
    html = MAKE["Diagnosis"]()._repr_html_()
    assert "color:inherit" in html and "background:none" in html
    assert re.findall(r"(?:color|background)\s*:\s*(?!inherit|none)\w*", html) == []


def test_a_diagnosis_says_what_is_missing_and_by_how_much_it_improves() -> None:
    text = repr(diagnosis())
    for words in (
        "explained",
        "office table, run 3",
        "dry friction",
        "98 %",
        "6.0 ± 0.2 N",
        "held out",
    ):
        assert words in text
    assert "0.123 → 0.008 m" in text


def test_an_unexplained_diagnosis_says_so() -> None:
    text = repr(diagnosis(answer() | {"verdict": "unexplained", "missing": []}))
    assert "unexplained" in text and "no effect of the catalogue" in text


def test_a_fit_shows_parameters_and_lack_of_fit() -> None:
    text = repr(fit())
    assert "does NOT explain these data: residual 3.2 N" in text
    assert "22.10 ± 0.10" in text and "not identifiable" in text and "… and" in text


def test_a_recording_shows_split_duration_and_rates() -> None:
    text = repr(recording())
    for words in (
        "3 episodes",
        "footprint 1.2 \N{MULTIPLICATION SIGN} 0.8 m",
        "2: episode_00, episode_01",
        "1: episode_02",
        "object 58.82 Hz",
        "wrench 100 Hz",
    ):
        assert words in text, text


PUBLIC_MODULES = [name for name in trundle.__all__ if inspect.ismodule(getattr(trundle, name))]


@pytest.mark.parametrize("name", PUBLIC_MODULES)
def test_completion_shows_public_names_only(name: str) -> None:
    module = getattr(trundle, name)
    assert dir(module) == sorted(module.__all__)
