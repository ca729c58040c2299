"""Sample diagnoses of a small table simulated in NumPy."""

from __future__ import annotations

import pytest

from tests.report.answers import Sample
from tests.report.samples import SAMPLES
from trundle.report import render


@pytest.fixture(scope="session")
def samples() -> dict[str, Sample]:
    """Every sample by name; tests copy before they change one."""
    return {name: make() for name, make in SAMPLES.items()}


@pytest.fixture(scope="session", params=sorted(SAMPLES))
def sample(request: pytest.FixtureRequest, samples: dict[str, Sample]) -> Sample:
    """Each sample in turn."""
    found: Sample = samples[request.param]
    return found


@pytest.fixture(scope="session")
def page(sample: Sample) -> str:
    """The page of each sample."""
    return render(*sample)
