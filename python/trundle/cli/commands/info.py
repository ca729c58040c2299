"""`trundle info`: summary statistics and a picture of a recording."""

from __future__ import annotations

import argparse
import json
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from trundle.cli.options import add_recording
from trundle.cli.paths import Output, declare

if TYPE_CHECKING:
    from trundle.joint_summary import JointSummary
    from trundle.summary import EpisodeSummary, NoiseLevels, RecordingSummary, StreamSummary

HELP = "Summarise a recording: episodes, rates, gaps, masked samples, forces, travel, noise; or its joints."
EXAMPLE = "trundle info recording/ --picture recording.png"

COLUMNS = "episode||length s|contact s|poses|Hz|gaps|masked|wrenches|Hz|gaps|peak N|travel m|turn rad"


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Add the recording, the picture and `--json`."""
    add_recording(parser)
    parser.add_argument("--picture", metavar="FILE", type=Path, help="also draw a .png, .svg or .pdf file")
    declare(parser, "picture", Output("--picture", "file", (".png", ".svg", ".pdf"), content="a picture"))
    parser.add_argument("--json", action="store_true", help="print the summary as JSON")


def run(args: argparse.Namespace) -> int:
    """Print the summary, and draw the picture if requested."""
    import trundle
    from trundle.joint_summary import JointSummary

    recording = trundle.read(args.recording)
    info = trundle.inspect(recording)
    if args.picture is not None:
        from trundle.picture import draw

        draw(recording, args.picture)
    text = (
        json.dumps(info.to_dict(), indent=2, ensure_ascii=False)
        if args.json
        else "\n".join(format_joints(info) if isinstance(info, JointSummary) else format_info(info))
    )
    print(text)
    return 0


def format_info(info: RecordingSummary) -> list[str]:
    """Format the summary as lines."""
    episodes = info.episodes
    held_out = sum(episode.held_out for episode in episodes)
    seconds = sum(episode.duration for episode in episodes)
    source = "given" if info.mass_given else "initial estimate from force and acceleration"
    return [
        info.name,
        f"  {len(episodes)} episodes, {held_out} held out, {seconds:.1f} s in total",
        f"  mass: {info.mass:.4g} kg ({source})",
        f"  noise: {format_noise(info.noise)}",
        "",
        *align([tuple(COLUMNS.split("|")), *(episode_row(episode) for episode in episodes)]),
    ]


def format_joints(info: JointSummary) -> list[str]:
    """Format the summary of a recording of joints as lines."""
    from trundle.joint_summary import format_noise as format_joint_noise

    episodes = info.episodes
    held_out = sum(episode.held_out for episode in episodes)
    seconds = sum(episode.duration for episode in episodes)
    return [
        info.name,
        f"  {len(episodes)} episodes, {held_out} held out, {seconds:.1f} s in total",
        f"  mechanism: {info.mechanism}",
        f"  noise: {', '.join(map(format_joint_noise, info.joints))}",
        "",
        *align([tuple(info.table.heads), *map(tuple, info.table.rows)]),
    ]


def format_noise(sd: NoiseLevels) -> str:
    """Format the noise."""
    x, y, theta = sd.pose
    source = "stated" if sd.stated else "estimated from the data"
    wrench = f"{sd.force:.3g} N, {sd.torque:.3g} N m"
    return f"pose {1e3 * x:.3g}, {1e3 * y:.3g} mm, {theta:.3g} rad; wrench {wrench} ({source})"


def episode_row(episode: EpisodeSummary) -> tuple[str, ...]:
    """Return the cells of an episode."""
    poses, wrench, counts = episode.object, episode.wrench, episode.counts
    return (
        episode.name,
        "held out" if episode.held_out else "",
        f"{episode.duration:.2f}",
        f"{episode.contact:.2f}",
        str(poses.samples),
        format_rate(poses),
        str(poses.gaps),
        str(counts.pose_outliers + counts.pose_held),
        str(wrench.samples),
        format_rate(wrench),
        str(wrench.gaps),
        f"{episode.peak_force:.2f}",
        f"{episode.travel[0]:.3f}",
        f"{episode.travel[1]:.2f}",
    )


def format_rate(stream: StreamSummary) -> str:
    """Format the samples per second."""
    return "-" if stream.rate is None else f"{stream.rate:.4g}"


def align(rows: Sequence[tuple[str, ...]]) -> list[str]:
    """Return rows of cells as aligned lines: the first two columns to the left, numbers to the right."""
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    justify = [str.ljust] * 2 + [str.rjust] * (len(widths) - 2)
    cells = (map(lambda pad, cell, width: pad(cell, width), justify, row, widths) for row in rows)
    return [("  " + "  ".join(row)).rstrip() for row in cells]
