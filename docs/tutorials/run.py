"""Execute the tutorials and store their outputs.

    python docs/tutorials/run.py [NAME ...] [--check]

A notebook is executed in a temporary folder that has the same place in the repository, so that
`../../configs` is found and files that the notebook writes leave no trace. An exception or a text on
standard error stops the run, and no notebook is then changed. A notebook whose modules (`requires` in its
metadata) are not installed keeps its stored outputs.
"""

from __future__ import annotations

import argparse
import base64
import importlib.util
import io
import os
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

import nbformat
from nbclient import NotebookClient
from PIL import Image

from trundle.atomic import write_text

FOLDER = Path(__file__).resolve().parent
ROOT = FOLDER.parents[1]
MAX_CELL_TIME_S = 600
"""Time after which a cell counts as hanging, s."""
COLOURS, MAX_WIDTH = 128, 1400
"""Number of colours and maximum width of a picture, pixels."""
METADATA = {
    "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
    "language_info": {"name": "python"},
}


def missing_modules(notebook: Any) -> list[str]:
    """Return the modules that a notebook requires and that are not installed."""
    required = notebook.metadata.get("trundle", {}).get("requires", [])
    return [module for module in required if importlib.util.find_spec(module) is None]


def execute(notebook: Any, name: str) -> None:
    """Execute all cells and keep their outputs, without execution times and versions.

    Raises
    ------
    nbclient.exceptions.CellExecutionError
        If a cell raises.
    RuntimeError
        If a cell writes to standard error.
    """
    with tempfile.TemporaryDirectory() as scratch:
        folder = Path(scratch, FOLDER.relative_to(ROOT))
        folder.mkdir(parents=True)
        for entry in ROOT.iterdir():
            if entry.name != folder.relative_to(scratch).parts[0]:
                Path(scratch, entry.name).symlink_to(entry)
        client = NotebookClient(
            notebook,
            timeout=MAX_CELL_TIME_S,
            kernel_name="python3",
            resources={"metadata": {"path": str(folder)}},
            record_timing=False,
            coalesce_streams=True,
            extra_arguments=["--IPKernelApp.log_level=ERROR"],
        )
        client.execute(env=kernel_environment())
    normalise(notebook, name)


def normalise(notebook: Any, name: str) -> None:
    """Remove what differs between machines, and compress pictures.

    Raises
    ------
    RuntimeError
        If an output is text on standard error.
    """
    for number, cell in enumerate(notebook.cells, 1):
        cell.metadata = {}
        for output in cell.get("outputs", []):
            if output.get("name") == "stderr":
                raise RuntimeError(f"{name}: cell {number} writes to standard error:\n{output['text']}")
            data = output.get("data", {})
            data.pop("text/latex", None)
            if "image/png" in data:
                data["image/png"] = compress(data["image/png"])
    kept = {key: notebook.metadata[key] for key in ("trundle",) if key in notebook.metadata}
    notebook.metadata = {**METADATA, **kept}


def compress(png: str) -> str:
    """Return a PNG in base64 with at most `COLOURS` colours and a width of at most `MAX_WIDTH`."""
    picture = Image.open(io.BytesIO(base64.b64decode(png))).convert("RGB")
    if picture.width > MAX_WIDTH:
        picture = picture.resize(
            (MAX_WIDTH, round(picture.height * MAX_WIDTH / picture.width)), Image.Resampling.LANCZOS
        )
    small = io.BytesIO()
    picture.quantize(COLOURS, Image.Quantize.FASTOCTREE).save(small, format="png", optimize=True)
    return base64.b64encode(small.getvalue()).decode()


def kernel_environment() -> dict[str, str]:
    """Return the environment of the kernel: the command `trundle` is found, and nothing animates."""
    path = os.pathsep.join([str(Path(sys.executable).parent), os.environ.get("PATH", "")])
    return {**os.environ, "PATH": path, "TQDM_DISABLE": "1", "NO_COLOR": "1", "COLUMNS": "100"}


def main() -> None:
    """Execute the notebooks of the command line, by default all."""
    parser = argparse.ArgumentParser(description="Execute the tutorials and store their outputs.")
    parser.add_argument("names", nargs="*", metavar="NAME", help="notebooks without suffix (default: all)")
    parser.add_argument("--check", action="store_true", help="execute only; do not store outputs")
    args = parser.parse_args()
    paths = [FOLDER / f"{name}.ipynb" for name in args.names] or sorted(FOLDER.glob("*.ipynb"))
    executed = {}
    for path in paths:
        notebook = nbformat.read(path, as_version=4)
        if missing := missing_modules(notebook):
            print(f"{path.stem}: not executed, needs {', '.join(missing)}")
            continue
        start = time.monotonic()
        execute(notebook, path.name)
        print(f"{path.stem}: {time.monotonic() - start:.0f} s", flush=True)
        executed[path] = nbformat.writes(notebook) + "\n"
    if not args.check:
        for path, text in executed.items():
            write_text(path, text)


if __name__ == "__main__":
    main()
