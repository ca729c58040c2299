"""Loads on the last link of an arm, of which the data determine moments only."""

from __future__ import annotations

import pytest

import trundle
from tests.mechanism_diagnosis.recordings import NOMINAL, recording_of

LINK_END = '<inertial pos="0 0 -0.15" mass="0.6" diaginertia="0.006 0.006 0.001"/>'


@pytest.mark.parametrize("mass", [0.15, 0.3])
def test_a_load_on_the_last_link_is_a_payload(mass: float) -> None:
    # The axes are parallel: a load changes moments and inertias, as other masses and a tilt do.
    load = f'<body pos="0 0 -0.3"><inertial pos="0 0 0" mass="{mass}" diaginertia="1e-6 1e-6 1e-6"/></body>'
    assert LINK_END in NOMINAL
    found = trundle.diagnose(recording_of(NOMINAL.replace(LINK_END, LINK_END + load)))
    names = {name for tie in found.answer["tied"] for name in tie} | set(found.missing)
    assert "payload:fore" in names, found.answer["missing"]
