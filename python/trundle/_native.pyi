"""Types and signatures of the compiled bindings. The docstrings are in the module itself."""

from collections.abc import Callable, Iterator, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, final

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

from trundle._types import (
    Answer,
    CalibrationRound,
    CalibrationTable,
    Estimate,
    FitSummary,
    Profile,
    SampleSummary,
    Score,
)
from trundle.episode import Episode

class TrundleError(ValueError): ...
class NotFiniteError(TrundleError): ...

@final
class Recording:
    def __new__(
        cls,
        metadata: Mapping[str, Any],
        episodes: Mapping[str, Mapping[str, ArrayLike]] | Mapping[str, pd.DataFrame] | Recording,
    ) -> Recording: ...
    @property
    def name(self) -> str: ...
    @property
    def metadata(self) -> dict[str, Any]: ...
    @property
    def episodes(self) -> dict[str, Episode]: ...
    def keys(self) -> list[str]: ...
    def values(self) -> list[Episode]: ...
    def items(self) -> list[tuple[str, Episode]]: ...
    def __len__(self) -> int: ...
    def __iter__(self) -> Iterator[str]: ...
    def __contains__(self, name: object, /) -> bool: ...
    def __getitem__(self, name: str, /) -> Episode: ...
    def _repr_html_(self) -> str: ...
    def frame(self, name: str) -> pd.DataFrame: ...
    def write(self, path: str | PathLike[str], table: Literal["csv", "parquet"] = "csv") -> None: ...

def read(path: str | PathLike[str]) -> Recording: ...
def _replace_folder(new: str | PathLike[str], path: str | PathLike[str]) -> None: ...
def _recover_folder(path: str | PathLike[str]) -> None: ...
def _inspect(recording: Recording | str | PathLike[str]) -> dict[str, Any]: ...
def _check(recording: Recording | str | PathLike[str]) -> list[dict[str, Any]]: ...
def prepare(
    recording: Recording | str | PathLike[str],
    tare: Literal["separated", "equation_12"] = "separated",
    wrench_pose: Literal["own_time", "latest"] = "own_time",
) -> dict[str, dict[str, Any]]: ...
def smooth(
    recording: Recording | str | PathLike[str], causal: bool = False
) -> dict[str, dict[str, NDArray[np.float64]]]: ...
def effects() -> list[dict[str, Any]]: ...

@final
class Model:
    @staticmethod
    def from_toml(text: str) -> Model: ...
    @staticmethod
    def read(path: str | PathLike[str]) -> Model: ...
    def to_toml(self) -> str: ...
    def freed(self) -> Model: ...
    def drawn(self, seed: int) -> Model: ...
    def write(self, path: str | PathLike[str]) -> None: ...
    def _repr_html_(self) -> str: ...
    @property
    def effects(self) -> list[str]: ...
    @property
    def parameters(self) -> list[dict[str, Any]]: ...
    def rollout(
        self,
        pose0: Sequence[float] | NDArray[np.float64],
        twist0: Sequence[float] | NDArray[np.float64],
        t: ArrayLike,
        wrench: ArrayLike,
        *,
        contact: float | None = None,
        inner: Sequence[float] | None = None,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...

@final
class Laws:
    def __new__(cls, model: Model, parameters: Mapping[str, float] | None = None) -> Laws: ...
    @property
    def mass(self) -> float: ...
    @property
    def com(self) -> tuple[float, float]: ...
    @property
    def inertia(self) -> float: ...
    @property
    def starts(self) -> list[float]: ...
    def wrench(
        self,
        pose: Sequence[float] | NDArray[np.float64],
        twist: Sequence[float] | NDArray[np.float64],
        t: float = 0.0,
        *,
        contact: float = 0.0,
        episode: float = ...,
        inner: Sequence[float] = ...,
    ) -> list[float]: ...
    def step(
        self,
        pose: Sequence[float] | NDArray[np.float64],
        twist: Sequence[float] | NDArray[np.float64],
        force: Sequence[float] | NDArray[np.float64],
        dt: float,
        t: float = 0.0,
        *,
        contact: float = 0.0,
        episode: float = ...,
        inner: Sequence[float] = ...,
    ) -> tuple[list[float], list[float], list[float]]: ...

def _diagnose_foreign(
    recording: Recording | str,
    step: Callable[[NDArray[np.float64], NDArray[np.float64], float, dict[str, float]], ArrayLike],
    parameters: Sequence[Mapping[str, Any]],
    *,
    given: bool = False,
    seed: int = 0,
    progress: Callable[[str, float], object] | None = None,
) -> _Outcome: ...
def _draw(model: Model, seed: int) -> dict[str, float]: ...
def _ranges(model: Model) -> list[tuple[str, str, float, tuple[float, float]]]: ...

_States = NDArray[np.float64]
_Columns = tuple[_States, NDArray[np.float64], NDArray[np.float64], _States]

@final
class _Regression:
    @staticmethod
    def linear(data: _Columns, features: str) -> _Regression: ...
    @staticmethod
    def local(data: _Columns, features: str) -> _Regression: ...
    def predict(self, before: _States, wrench: NDArray[np.float64], dt: NDArray[np.float64]) -> _States: ...
    @property
    def widths(self) -> list[float] | None: ...

def _transitions(model: Model, n: int, seed: int, settings: Mapping[str, float]) -> _Columns: ...
def _cut(recording: Recording | str | PathLike[str], dt: float, held_out: bool) -> _Columns: ...
def _noisy(data: _Columns, sd: Sequence[float], seed: int) -> _States: ...
def _noise_sd(sigma: float, reading: str, data: _Columns) -> list[float]: ...
def _hold(model: Model, before: _States, wrench: NDArray[np.float64], dt: NDArray[np.float64]) -> _States: ...
def _r2(predicted: _States, after: _States) -> float: ...
def _object(path: str | PathLike[str]) -> dict[str, Any]: ...

__version__: str

@final
class Planner:
    def __new__(cls, lower: ArrayLike, upper: ArrayLike, *, seed: int = 0, **settings: Any) -> Planner: ...
    def plan(
        self,
        model: Model | Sequence[Model],
        pose: Sequence[float] | NDArray[np.float64],
        twist: Sequence[float] | NDArray[np.float64],
        goal: Sequence[float] | NDArray[np.float64],
        grasp: Sequence[float] | NDArray[np.float64],
        obstacles: Sequence[Sequence[Sequence[float]]] = ...,
        *,
        inner: Sequence[float] = ...,
        learnt: _Regression | None = None,
    ) -> NDArray[np.float64]: ...
    def regret(
        self,
        models: Sequence[Model],
        pose: Sequence[float] | NDArray[np.float64],
        twist: Sequence[float] | NDArray[np.float64],
        goal: Sequence[float] | NDArray[np.float64],
        grasp: Sequence[float] | NDArray[np.float64],
        obstacles: Sequence[Sequence[Sequence[float]]] = ...,
        *,
        inner: Sequence[float] = ...,
    ) -> float: ...
    def be_curious(self, curiosity: float) -> None: ...
    def compare(
        self,
        model: Model | Sequence[Model],
        pose: Sequence[float] | NDArray[np.float64],
        twist: Sequence[float] | NDArray[np.float64],
        goal: Sequence[float] | NDArray[np.float64],
        grasps: Sequence[Sequence[float]] | NDArray[np.float64],
        obstacles: Sequence[Sequence[Sequence[float]]] = ...,
        *,
        inner: Sequence[float] = ...,
    ) -> NDArray[np.float64]: ...
    def advance(self, seconds: float) -> None: ...
    def restart(self) -> None: ...
    @property
    def hold(self) -> float: ...

@final
class _Outcome:
    @property
    def answer(self) -> Answer: ...
    @property
    def series(self) -> dict[str, Any]: ...
    @property
    def model(self) -> Model: ...
    def write(self, folder: str | PathLike[str]) -> None: ...

def _fit(
    recordings: Sequence[Recording | str],
    model: Model | None = None,
    *,
    choice: Mapping[str, Any],
    per_episode: Sequence[str] = ...,
    prior: tuple[str, str] | None = None,
    start: Mapping[str, float] | None = None,
    starts: int = 6,
    seed: int = 0,
    optimiser: str = "lm",
    progress: Callable[[str, float], object] | None = None,
) -> tuple[FitSummary, Model]: ...
def _profile(
    recording: Recording | str,
    parameter: str,
    model: Model | None = None,
    *,
    prior: tuple[str, str] | None = None,
    grid: Sequence[float] | None = None,
    starts: int = 6,
    seed: int = 0,
    progress: Callable[[str, float], object] | None = None,
) -> Profile: ...

@final
class _Online:
    def __new__(
        cls,
        metadata: Mapping[str, Any],
        model: Model | None = None,
        *,
        starts: int = 6,
        seed: int = 0,
        kept: int = 16,
    ) -> _Online: ...
    def update(self, push: Mapping[str, ArrayLike] | Recording) -> None: ...
    def peek(self, push: Mapping[str, ArrayLike]) -> None: ...
    def abandon(self) -> None: ...
    def estimate(self) -> list[Estimate]: ...
    def model(self) -> Model | None: ...
    @property
    def pushes(self) -> int: ...
    @property
    def hypotheses(self) -> int: ...

@final
class _Predictions:
    @property
    def held_out(self) -> list[str]: ...
    def columns(self) -> dict[str, Any]: ...
    def scores(self) -> tuple[Score | None, Score | None]: ...
    def write(self, path: str | PathLike[str]) -> None: ...

def _predict(recording: Recording | str, model: Model) -> _Predictions: ...
def _platt() -> list[float]: ...
def _sources(which: Literal["diagnosis", "all"]) -> str: ...
def _diagnose(
    recording: Recording | str,
    model: Model | None = None,
    *,
    seed: int = 0,
    without: list[str] = ...,
    wrench_pose: str = "own_time",
    progress: Callable[[str, float], object] | None = None,
) -> _Outcome: ...
def _design(
    first: Model,
    second: Model,
    *,
    recording: Recording | str | None = None,
    body: Model | None = None,
    noise: tuple[float, float, float, float],
    limits: Mapping[str, float],
    count: int = 1,
    progress: Callable[[str, float], object] | None = None,
) -> tuple[dict[str, Any], Model, Model]: ...
def simulate(scenario: str | PathLike[str], seed: int = 0) -> Recording: ...
def demo(seed: int = 0) -> Recording: ...

_Pose = tuple[float, float, float]

@final
class Snapshot:
    """State of an episode, including random numbers and clock. It can be pickled."""

    def __new__(cls, options: str, state: bytes) -> Snapshot: ...
    def __getnewargs__(self) -> tuple[str, bytes]: ...

@final
class Pushing:
    ARENA: float
    REGRASP: float
    TOP_SPEED: float
    TOP_SPIN: float
    HOUSEHOLD: list[str]
    OBJECT_SETS: list[tuple[str, str, list[str], tuple[float, float], list[str], tuple[float, float]]]
    def __new__(cls, options: str) -> Pushing: ...
    @staticmethod
    def default_costs(version: int) -> tuple[float, float, float]: ...
    @property
    def full(self) -> list[float]: ...
    @property
    def varied(self) -> bool: ...
    @property
    def bounds(self) -> list[float]: ...
    @property
    def horizon(self) -> int: ...
    @property
    def control(self) -> float: ...
    def reset(
        self,
        seed: int | None,
        start: Sequence[float] | None = None,
        goal: Sequence[float] | None = None,
        grasp: Sequence[float] | None = None,
        same_object: bool = False,
    ) -> NDArray[np.float64]: ...
    def step(self, action: Any) -> tuple[NDArray[np.float64], float, bool, bool, dict[str, Any]] | None: ...
    @property
    def ready(self) -> bool: ...
    @property
    def seeded(self) -> bool: ...
    @property
    def objects(self) -> int: ...
    def view(self) -> dict[str, Any] | None: ...
    def hidden(self) -> dict[str, Any] | None: ...
    def hidden_values(self) -> NDArray[np.float64]: ...
    def record(self) -> None: ...
    def take_rows(self) -> dict[str, NDArray[np.float64]]: ...
    def metadata(self, name: str) -> dict[str, Any]: ...
    def snapshot(self) -> Snapshot: ...
    def restore(self, snapshot: Snapshot) -> None: ...

@final
class Batch:
    COLUMNS: list[str]
    def __new__(cls, options: str, count: int, autoreset: str) -> Batch: ...
    def reset(
        self,
        seeds: Sequence[tuple[int | None] | None],
        observations: NDArray[np.float64],
        start: Sequence[float] | None = None,
        goal: Sequence[float] | None = None,
        grasp: Sequence[float] | None = None,
        same_object: bool = False,
    ) -> None: ...
    @property
    def ready(self) -> bool: ...
    def step(
        self,
        actions: Any,
        observations: NDArray[np.float64],
        finals: NDArray[np.float64],
        table: NDArray[np.float64],
    ) -> None: ...
    def view(self, index: int) -> dict[str, Any] | None: ...
    def hidden_values(self) -> NDArray[np.float64]: ...
    @property
    def seeded(self) -> list[bool]: ...
    def ended(self, index: int) -> bool: ...
    def snapshot(self, index: int) -> Snapshot: ...
    def restore(self, index: int, snapshot: Snapshot) -> None: ...

def _learning_curves(
    truth: Model,
    form: Model,
    learners: Sequence[str],
    counts: Sequence[int],
    noise: tuple[str, float],
    seed: int,
    *,
    tested: int = 200,
    starts: int = 8,
    progress: Callable[[str, float], object] | None = None,
) -> tuple[list[list[float]], float]: ...
def _open_loop(
    truth: Model,
    form: Model,
    course: Mapping[str, Any],
    sizes: Sequence[float],
    counts: Sequence[int],
    noise: tuple[str, float],
    seed: int,
    *,
    tested: int = 200,
    starts: int = 8,
    progress: Callable[[str, float], object] | None = None,
) -> list[dict[str, Any]]: ...

@final
class _Posterior:
    @property
    def summary(self) -> SampleSummary: ...
    def draws(self) -> NDArray[np.float64]: ...
    def stats(self) -> dict[str, NDArray[Any]]: ...
    def log_likelihood(self) -> tuple[list[str], NDArray[np.float64]]: ...
    def predictive(
        self, draws: int, seed: int
    ) -> dict[str, tuple[bool, NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]]: ...

def _sample(
    recording: Recording | str,
    model: Model | None = None,
    *,
    prior: tuple[str, str] | None = None,
    method: str = "laplace",
    chains: int = 4,
    draws: int = 250,
    warmup: int = 150,
    starts: int = 6,
    seed: int = 0,
    progress: Callable[[str, float], object] | None = None,
) -> _Posterior: ...
def _calibrate(
    text: str,
    rounds: Sequence[int],
    *,
    method: str | None = None,
    seed: int = 0,
    progress: Callable[[str, float], object] | None = None,
) -> list[CalibrationRound]: ...
def _calibration_table(
    text: str, rounds: Sequence[CalibrationRound], *, method: str | None = None
) -> CalibrationTable: ...
