"""Diagnose a recording in a process of its own, which receives only the recording's folder."""

from __future__ import annotations

import json
import math
import os
import resource
import signal
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

__all__ = ["diagnose_case"]


def diagnose_case(
    digest: str, limit: float, folder: Path, without: Sequence[str] = (), experiments: bool = False
) -> dict[str, Any]:
    """Diagnose a folder; return a summary of the answer, and its cost.

    Parameters
    ----------
    digest : str
        Of the recording: part of the unit's key.
    limit : float
        Processor time after which the process is ended, s. The verdict is then "timeout". Processor time
        does not depend on the load of the machine.
    folder : Path
    without : sequence of str
        Effects that are not offered.
    experiments : bool
        Whether the summary has the proposed experiments.
    """
    request = json.dumps([str(folder), math.ceil(limit), list(without), experiments])
    with tempfile.TemporaryFile() as out, tempfile.TemporaryFile() as errors:
        began = time.perf_counter()
        command = [sys.executable, "-m", "trundle.experiments.blind.diagnose", request]
        process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=out, stderr=errors)
        try:
            _, status, usage = os.wait4(process.pid, 0)
            process.returncode = os.waitstatus_to_exitcode(status)
        finally:
            process.kill()
        seconds = time.perf_counter() - began
        for file in (out, errors):
            file.seek(0)
        answer = parse_answer(process.returncode, out.read(), errors.read())
    cost = {"seconds": seconds, "cpu": usage.ru_utime + usage.ru_stime, "memory": usage.ru_maxrss / 1024}
    return {**answer, "cost": cost}


def parse_answer(status: int, out: bytes, errors: bytes) -> dict[str, Any]:
    """Return the answer of a process that has ended."""
    if status == 0:
        found: dict[str, Any] = json.loads(out)
        return found
    if status == -signal.SIGXCPU:
        return {"verdict": "timeout", "reason": ""}
    lines = errors.decode(errors="replace").strip().splitlines()
    return {"verdict": "crashed", "reason": f"exit {status}: {lines[-1] if lines else ''}"}


def main(request: str) -> None:
    """Diagnose a folder and print a summary of the answer."""
    folder, limit, without, experiments = json.loads(request)
    resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))
    import trundle

    # Standard input closes when the parent process ends.
    threading.Thread(target=end_with_parent, daemon=True).start()
    try:
        answer = trundle.diagnose(Path(folder), without=without).answer
    except trundle.TrundleError as error:
        # The benchmark's folder must not appear in the answer.
        reason = str(error).replace(f"{Path(folder).parent}/", "")
        json.dump({"verdict": "refused", "reason": reason}, sys.stdout)
        return
    proposed = {"experiments": [*map(summarize_experiment, answer["experiments"])]} if experiments else {}
    json.dump({**summarize_answer(answer), **proposed}, sys.stdout)


def end_with_parent() -> None:
    """Wait for the end of standard input, then end the process."""
    os.read(0, 1)  # sys.stdin would hold a lock that the interpreter needs at exit
    os.kill(os.getpid(), signal.SIGKILL)


def summarize_answer(answer: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parts of `diagnosis.json` that scoring uses."""
    names = ("effect", "probability", "parameters", "where", "explains")
    figures = (
        *("window_position_rmse", "window_heading_rmse", "position_rmse", "heading_rmse"),
        "relative_effort_rmse",
    )

    held_out = answer["fit"]["held_out"] or {}
    residual = answer.get("residual") or {}
    return {
        **{key: residual[key] for key in ("explained",) if key in residual},
        "verdict": answer["verdict"],
        "missing": [{name: one.get(name) for name in names} for one in answer["missing"]],
        "tied": [[name.partition(":")[0] for name in tie] for tie in answer.get("tied", [])],
        "tied_sets": [
            [[name.partition(":")[0] for name in one] for one in sets] for sets in answer.get("tied_sets", [])
        ],
        "immaterial": [one["effect"] for one in answer.get("immaterial", [])],
        "alternatives": [
            {k: one.get(k) for k in ("effect", "probability")} for one in answer["alternatives"]
        ],
        "warnings": answer.get("warnings", []),
        "nominal": {when: answer["nominal"].get(when) for when in ("before", "after")},
        "held_out": {
            when: {name: found[name] for name in figures if name in found}
            for when, found in held_out.items()
            if found
        },
    }


def summarize_experiment(experiment: Mapping[str, Any]) -> dict[str, Any]:
    """Return the parts of a proposed experiment that simulating and scoring it use."""
    names = ("grasp", "direction", "start", "profile", "knots")
    pushes = [{name: push[name] for name in names} for push in experiment["pushes"]]
    return {**{name: experiment[name] for name in ("models", "separation", "sure")}, "pushes": pushes}


if __name__ == "__main__":
    main(sys.argv[1])
