"""The imported published data sets; their tests are skipped without the data."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

import trundle
from examples import real_recordings

RealData = Callable[[str], Path]


@pytest.fixture(scope="session")
def axis(real_data: RealData) -> trundle.Recording:
    return real_recordings.emps(real_data("emps").parent)


@pytest.fixture(scope="session")
def pushes(real_data: RealData) -> dict[str, trundle.Recording]:
    return real_recordings.pushes(real_data("cmu-planar-push").parent)


@pytest.fixture(scope="session")
def later_logs(real_data: RealData) -> trundle.Recording:
    return real_recordings.logs(real_data("cmu-planar-push").parent, earlier=False)


@pytest.fixture(scope="session")
def earlier_logs(real_data: RealData) -> trundle.Recording:
    return real_recordings.logs(real_data("cmu-planar-push").parent, earlier=True)


@pytest.fixture(scope="session")
def seals(real_data: RealData) -> dict[str, trundle.Recording]:
    data = real_data("pneumatic-seal").parent
    names = (*real_recordings.SEALS, *real_recordings.ALL_PRESSURES)
    return {name: real_recordings.seal(data, name) for name in names}
