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
def demo(tmp_path_factory: pytest.TempPathFactory) -> Demo:
    """Run the demo once for all tests of this folder."""
    demo = Demo(tmp_path_factory.mktemp("demo"))
    for line in (
        ["simulate", SCENARIO, "--out", "recording"],
        ["diagnose", "recording", "--out", "diagnosis"],
    ):
        ran = trundle(demo.folder, *line)
        assert ran.returncode == 0, ran.stderr
    return demo
