"""`trundle play`: run episodes of an environment, with animation and recording."""

from __future__ import annotations

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trundle.cli.options import add_seed
from trundle.cli.paths import RECORDING, Output, declare
from trundle.cli.settings_pairs import add_set, parse_pairs

if TYPE_CHECKING:
    import gymnasium

    from trundle.experiments.training.policy import Policy

HELP = "Run episodes of an environment; print their outcomes, animate them, save them as a recording."
EXAMPLE = "trundle play PushDoor --set action=velocity --episodes 3 --gif door.gif --out recordings/door"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the task, the agent and the outputs."""
    parser.add_argument(
        "task",
        metavar="TASK",
        help="PushPose, PushPath, PushAround, PushDoor or LockedWheel, with a level or a version if wanted: "
        "PushAroundHard, PushDoor-v1 (default: the first version)",
    )
    parser.add_argument("--episodes", type=int, default=1, help="number of episodes (default 1)")
    parser.add_argument(
        "--agent",
        metavar="AGENT",
        default="random",
        help="random: a new action every half second (default); adaptive: trundle.AdaptiveAgent; or the .npz "
        "file of a policy from `trundle train`, which also sets the arguments of its environment",
    )
    add_set(parser, "set an argument of the environment, such as action=push or noise=0")
    parser.add_argument(
        "--out", metavar="FOLDER", type=Path, help="save the sensor readings as a recording in this folder"
    )
    display = parser.add_mutually_exclusive_group()
    display.add_argument("--gif", metavar="FILE", type=Path, help="write an animation of all episodes")
    declare(parser, "out", RECORDING)
    declare(parser, "gif", Output("--gif", "file", (".gif",), content="an animation"))
    display.add_argument("--human", action="store_true", help="show a window (needs trundle[human])")
    add_seed(parser)


def run(args: argparse.Namespace) -> int:
    """Run the episodes and print the outcome of each."""
    from trundle.playing import Animation, play, select_agent

    agent = select_agent(args.agent)
    env = _make_environment(args, agent)
    animation = Animation(args.gif) if args.gif else None
    try:
        for number, outcome in enumerate(play(env, agent, args.episodes, args.seed, animation)):
            print(f"episode {number}: {outcome}")
    finally:
        env.close()
    if animation:
        animation.write()
        print(f"{args.gif}: {animation.length} frames")
    if args.out:
        print(f"{args.out}: recording; run `trundle diagnose {args.out}` to identify the hidden effects")
    return 0


def _make_environment(args: argparse.Namespace, agent: str | Policy) -> gymnasium.Env[Any, Any]:
    import gymnasium

    import trundle
    from trundle.envs.ids import flat_id, flat_ids

    name = flat_id(args.task)
    if name is None:
        known = ", ".join(one.removeprefix("trundle/") for one in flat_ids())
        raise trundle.TrundleError(f"TASK = {args.task}: choose one of {known}")
    mode = "human" if args.human else "rgb_array" if args.gif else None
    trained = {} if isinstance(agent, str) else agent.about.env_kwargs
    if not isinstance(agent, str) and agent.about.env != name:
        raise trundle.TrundleError(
            f"--agent {args.agent}: the policy was trained in {agent.about.env}, not in {name}"
        )
    try:
        env = gymnasium.make(name, render_mode=mode, **{**trained, **parse_pairs(args.set)})
    except TypeError as error:
        raise trundle.TrundleError(f"--set {' '.join(args.set)}: {error}") from None
    env = env if args.out is None else trundle.Record(env, args.out)
    is_privileged = not isinstance(agent, str) and agent.about.hidden > 0
    return trundle.envs.Oracle(env) if is_privileged else env
