"""`trundle play`: episodes of an environment, watched, drawn and recorded."""

from __future__ import annotations

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING, Any

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

from trundle.cli.options import add_seed

if TYPE_CHECKING:
    import gymnasium

    from trundle.experiments.training.policy import Policy

HELP = "Play episodes of an environment: print how they end, animate them, keep them as a recording."
EXAMPLE = "trundle play PushDoor --set action=velocity --episodes 3 --gif door.gif --out recordings/door"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the task, who plays, and what is kept."""
    parser.add_argument(
        "task", metavar="TASK", help="PushPose, PushPath, PushAround, PushDoor or LockedWheel"
    )
    parser.add_argument("--episodes", type=int, default=1, help="how many (default: 1)")
    parser.add_argument(
        "--agent",
        metavar="AGENT",
        default="random",
        help="random: a new action each half second (default); adaptive: trundle.AdaptiveAgent; or a FILE "
        "(.npz) that `trundle train` wrote, which brings the arguments of its environment",
    )
    parser.add_argument(
        "--set",
        metavar="NAME=VALUE",
        action="append",
        default=[],
        help="an argument of the environment, such as action=push or noise=0; may be repeated",
    )
    parser.add_argument(
        "--out", metavar="FOLDER", type=Path, help="keep what the instruments saw as a recording"
    )
    shown = parser.add_mutually_exclusive_group()
    shown.add_argument("--gif", metavar="FILE", type=Path, help="draw an animation of all episodes")
    shown.add_argument("--human", action="store_true", help="show a window (extra: trundle[human])")
    add_seed(parser)


def run(args: argparse.Namespace) -> int:
    """Play, and say how each episode ended."""
    from trundle.playing import Animation, play, select_agent

    agent = select_agent(args.agent)
    env = _make_environment(args, agent)
    film = Animation(args.gif) if args.gif else None
    try:
        for number, ended in enumerate(play(env, agent, args.episodes, args.seed, film)):
            print(f"episode {number}: {ended}")
    finally:
        env.close()
    if film:
        film.write()
        print(f"{args.gif}: {film.length} pictures")
    if args.out:
        print(f"{args.out}: a recording; `trundle diagnose {args.out}` says what was hidden")
    return 0


def _make_environment(args: argparse.Namespace, agent: str | Policy) -> gymnasium.Env[Any, Any]:
    import gymnasium

    import trundle

    known = sorted(task.__name__ for task in trundle.envs.FLAT)
    if args.task not in known:
        raise trundle.TrundleError(f"TASK = {args.task}: choose {', '.join(known)}")
    mode = "human" if args.human else "rgb_array" if args.gif else None
    name, trained = f"trundle/{args.task}-v0", {} if isinstance(agent, str) else agent.about.env_kwargs
    if not isinstance(agent, str) and agent.about.env != name:
        raise trundle.TrundleError(f"--agent {args.agent}: this policy was trained in {agent.about.env}")
    try:
        env = gymnasium.make(name, render_mode=mode, **{**trained, **_parse_arguments(args.set)})
    except TypeError as error:
        raise trundle.TrundleError(f"--set {' '.join(args.set)}: {error}") from None
    return env if args.out is None else trundle.Record(env, args.out)


def _parse_arguments(pairs: list[str]) -> dict[str, Any]:
    """Read NAME=VALUE, a value as in TOML, or a word."""
    import trundle

    arguments = {}
    for pair in pairs:
        name, sign, text = pair.partition("=")
        if not sign:
            raise trundle.TrundleError(f"--set {pair}: write NAME=VALUE")
        try:
            arguments[name] = tomllib.loads(f"value = {text}")["value"]
        except tomllib.TOMLDecodeError:
            arguments[name] = text
    return arguments
