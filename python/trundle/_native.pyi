"""The compiled half of the package: types and signatures; the docstrings are in the module itself."""

from collections.abc import Mapping
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
