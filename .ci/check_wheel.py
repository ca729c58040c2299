"""Install a wheel with its core dependencies into a new environment and run the first diagnosis there.

    python .ci/check_wheel.py dist/trundle-*.whl

Prints the installed size and the times. Exits with status 1 if a step fails, if a package is installed that
is not a core dependency, or if the installation is larger than `MAX_INSTALL_MB`.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
import tempfile
import time
import venv
from pathlib import Path

MAX_INSTALL_MB = 150
"""Limit of the installed size of trundle with its core dependencies."""
MAX_FIRST_DIAGNOSIS_S = 300
"""Time in which installation, simulation and diagnosis should finish, s; reported, not enforced."""
CORE = {
    "cloudpickle",
    "farama-notifications",
    "gymnasium",
    "jinja2",
    "markupsafe",
    "numpy",
    "tomli",
    "tomli-w",
    "tqdm",
    "trundle",
    "typing-extensions",
}
"""trundle, its core dependencies and what these need."""
INSTALLED = "import importlib.metadata as m; print(*{d.metadata['Name'] for d in m.distributions()})"
SITE_PACKAGES = "import sysconfig; print(sysconfig.get_path('purelib'))"


def main() -> int:
    """Check the wheel in the first argument."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("wheel", type=Path, help="wheel to check")
    wheel = parser.parse_args().wheel.resolve()
    with tempfile.TemporaryDirectory(prefix="trundle-wheel-") as place:
        return check(wheel, Path(place))


def check(wheel: Path, place: Path) -> int:
    """Install the wheel below `place`, diagnose, report; return an exit status."""
    began = time.perf_counter()
    environment = place / "venv"
    venv.create(environment, with_pip=True)
    scripts = environment / ("Scripts" if os.name == "nt" else "bin")
    suffix = ".exe" if os.name == "nt" else ""
    python, trundle = scripts / f"python{suffix}", scripts / f"trundle{suffix}"
    packages = Path(output(python, "-c", SITE_PACKAGES))
    before = size_mb(packages)
    run(python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", wheel)
    installed = time.perf_counter()
    size = size_mb(packages) - before
    names = {name.lower().replace("_", "-") for name in output(python, "-c", INSTALLED).split()}
    extra = sorted(names - CORE - {"pip", "setuptools"})
    run(trundle, "simulate", "--demo", "--out", place / "recording")
    run(trundle, "diagnose", place / "recording", "--out", place / "diagnosis", "--quiet")
    diagnosed = time.perf_counter()
    report = (place / "diagnosis" / "report.html").stat().st_size
    print(f"{wheel.name}, Python {output(python, '-c', 'import platform; print(platform.python_version())')}")
    print(f"  installed size      {size:6.1f} MB (limit {MAX_INSTALL_MB} MB)")
    print(f"  installation        {installed - began:6.1f} s")
    print(f"  first diagnosis     {diagnosed - installed:6.1f} s, report of {report / 1e6:.1f} MB")
    print(f"  together            {diagnosed - began:6.1f} s (goal {MAX_FIRST_DIAGNOSIS_S} s)")
    if extra:
        print(f"  not core dependencies, but installed: {', '.join(extra)}", file=sys.stderr)
    return int(bool(extra) or size > MAX_INSTALL_MB)


def run(*command: str | Path) -> None:
    """Run a command outside the repository; end this program if it fails."""
    if subprocess.run(command, cwd=tempfile.gettempdir(), env=clean_environment()).returncode:
        sys.exit(f"failed: {' '.join(map(str, command))}")


def output(*command: str | Path) -> str:
    """Return the standard output of a command."""
    return subprocess.check_output(command, text=True, env=clean_environment()).strip()


def clean_environment() -> dict[str, str]:
    """Return the environment without variables that lead to another Python or to the sources."""
    return {
        key: value
        for key, value in os.environ.items()
        if key not in ("PYTHONPATH", "PYTHONHOME", "VIRTUAL_ENV")
    }


def size_mb(folder: Path) -> float:
    """Return the size of the files in a folder, MB."""
    return sum(path.stat().st_size for path in folder.rglob("*") if path.is_file()) / 1e6


if __name__ == "__main__":
    sys.exit(main())
