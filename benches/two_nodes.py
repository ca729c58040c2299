"""A blind benchmark on a Ray cluster of two nodes, one of which is killed, compared with one process.

python benches/two_nodes.py --cases 2 --kill-after 2

The cluster runs on this machine, with one processor per node. The second node is killed when the given number
of units is finished. The script prints both times and fails if the results differ by a byte. Costs of the
diagnoses (time, memory) are in a file of their own and are not compared.
"""

from __future__ import annotations

import argparse
import subprocess
import sys
import tempfile
import threading
from pathlib import Path
from time import perf_counter, sleep
from typing import Any

CONFIG = """
format = "trundle-wide/1"
effects = ["all"]
outside = ["all"]
[ranges.tune]
first = 72000
clean = {clean}
singles = {singles}
"""


def prove(config: Path, work: Path, *options: str) -> float:
    """Run the benchmark in a process of its own; return its seconds."""
    began = perf_counter()
    command = [
        sys.executable,
        "-m",
        "trundle",
        "prove",
        "--config",
        str(config),
        "--range",
        "tune",
        "--quiet",
    ]
    folders = ["--work", str(work), "--out", str(work / "out")]
    subprocess.run([*command, *folders, *options], check=True, stdout=subprocess.DEVNULL)
    return perf_counter() - began


def finished_units(work: Path) -> int:
    """Return the number of units with a result."""
    return sum(1 for path in work.rglob("units/*") if path.is_file() and not path.name.startswith("."))


def kill_node(cluster: Any, work: Path, after: int) -> None:
    """Kill the second node once `after` units are finished."""
    while finished_units(work) < after:
        sleep(0.2)
    cluster.remove_node(cluster.list_all_nodes()[1], allow_graceful=False)
    print(f"second node killed after {finished_units(work)} units", flush=True)


def results(work: Path) -> dict[str, bytes]:
    """Return the files of results without those of costs."""
    found = {path.relative_to(work / "out").as_posix(): path for path in (work / "out").rglob("*.json*")}
    return {name: path.read_bytes() for name, path in found.items() if ".cost." not in name}


def main() -> None:
    """Run both, and compare their results."""
    from ray.cluster_utils import Cluster

    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--cases", type=int, default=2, help="recordings, half of them clean (default 2)")
    parser.add_argument("--kill-after", type=int, default=2, metavar="N", help="finished units (default 2)")
    args = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        one, two = Path(folder) / "one", Path(folder) / "two"
        config = Path(folder) / "wide.toml"
        clean = args.cases // 2
        config.write_text(CONFIG.format(clean=clean, singles=args.cases - clean), encoding="utf-8")
        print(f"one process      {prove(config, one):8.1f} s", flush=True)
        cluster: Any = Cluster(initialize_head=True, head_node_args={"num_cpus": 1})
        cluster.add_node(num_cpus=1)
        threading.Thread(target=kill_node, args=(cluster, two, args.kill_after), daemon=True).start()
        seconds = prove(config, two, "--backend", "ray", "--address", cluster.address)
        print(f"two Ray nodes    {seconds:8.1f} s")
        cluster.shutdown()
        first, second = results(one), results(two)
    if first != second or not first:
        sys.exit(f"results differ: {sorted(first)}, {sorted(second)}")
    print(f"{len(first)} files of results are equal byte for byte")


if __name__ == "__main__":
    main()
