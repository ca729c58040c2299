from dataclasses import dataclass
from pathlib import Path

import pytest

from tests.command import trundle

SCENARIO = Path(__file__).resolve().parents[2] / "configs/experiments/demo.toml"


@dataclass(frozen=True)
class Demo:
    """Output of `make demo`."""

    folder: Path

    @property
    def recording(self) -> Path:
        return self.folder / "recording"

    @property
    def diagnosis(self) -> Path:
        return self.folder / "diagnosis"


@pytest.fixture(scope="session")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Simulate the recording of the demo."""
    folder = tmp_path_factory.mktemp("demo")
    ran = trundle(folder, "simulate", SCENARIO, "--out", "recording")
    assert ran.returncode == 0, ran.stderr
    return folder / "recording"


@pytest.fixture(scope="session")
def demo(recording: Path) -> Demo:
    """Run the demo once for all tests of this folder."""
    demo = Demo(recording.parent)
    ran = trundle(demo.folder, "diagnose", "recording", "--out", "diagnosis")
    assert ran.returncode == 0, ran.stderr
    return demo
