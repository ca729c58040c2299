"""The stub of the native module agrees with it: names, parameters and defaults. `make lint` checks types."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]

# Without the types of other modules, which take three times as long.
SETTINGS = """
[tool.mypy]
follow_imports = "skip"
disable_error_code = ["valid-type"]
"""


def test_the_stub_agrees_with_the_native_module(tmp_path: Path) -> None:
    allowed = tmp_path / "allowed"
    allowed.write_text("trundle._native.__all__\n")  # PyO3 makes it
    settings = tmp_path / "settings.toml"
    settings.write_text(SETTINGS)
    line = [sys.executable, "-m", "mypy.stubtest", "trundle._native", "--allowlist", str(allowed)]
    line += ["--mypy-config-file", str(settings)]
    environment = os.environ | {"MYPYPATH": str(ROOT / "python")}
    ran = subprocess.run(line, capture_output=True, text=True, env=environment, check=False, cwd=tmp_path)
    assert ran.returncode == 0, ran.stdout + ran.stderr
