"""The compiled half of the package: types and signatures; the docstrings are in the module itself."""

from collections.abc import Callable, Mapping, Sequence
from os import PathLike
from typing import Any, Literal, final

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike, NDArray

class TrundleError(ValueError): ...

@final
class Recording:
    def __new__(
        cls, metadata: Mapping[str, Any], episodes: Mapping[str, Mapping[str, ArrayLike] | pd.DataFrame]
    ) -> Recording: ...
    @property
    def name(self) -> str: ...
    @property
    def metadata(self) -> dict[str, Any]: ...
    @property
    def episodes(self) -> dict[str, dict[str, NDArray[np.float64]]]: ...
    def frame(self, name: str) -> pd.DataFrame: ...
    def write(self, path: str | PathLike[str], table: Literal["csv", "parquet"] = "csv") -> None: ...

def read(path: str | PathLike[str]) -> Recording: ...

def effects() -> list[dict[str, Any]]: ...
@final
class Model:
    @staticmethod
    def from_toml(text: str) -> Model: ...
    @staticmethod
    def read(path: str | PathLike[str]) -> Model: ...
    def to_toml(self) -> str: ...
    def write(self, path: str | PathLike[str]) -> None: ...
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
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]: ...

__version__: str

@final
class _Outcome:
    @property
    def answer(self) -> str: ...
    @property
    def series(self) -> str: ...
    @property
    def model(self) -> str: ...
    def write_predictions(self, path: str | PathLike[str]) -> None: ...

def _fit(
    recording: Recording | str,
    model: str | None = None,
    *,
    starts: int = 6,
    seed: int = 0,
    progress: Callable[[str, float], object] | None = None,
) -> tuple[str, str]: ...
def _predict(recording: Recording | str, model: str, out: str | PathLike[str]) -> None: ...
def _diagnose(
    recording: Recording | str,
    model: str | None = None,
    *,
    seed: int = 0,
    progress: Callable[[str, float], object] | None = None,
) -> _Outcome: ...
