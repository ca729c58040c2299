"""The page of a run: the result, the belief after each fit, and how to reproduce it."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import resources

from trundle import __version__
from trundle.experiments.runs.config import Settings
from trundle.experiments.runs.history import Episode
from trundle.experiments.runs.sections import Part, answer, parts
from trundle.experiments.runs.sentences import format_seconds, headline, summary
from trundle.report.markup import Html, tag
from trundle.report.quantity import ABSENT, format_quantity
from trundle.report.section import contents, section
from trundle.report.tables import table

__all__ = ["render"]

PACKAGE = "trundle.experiments.runs"


def render(settings: Settings, config: str, episodes: Sequence[Episode]) -> str:
    """Render the page.

    Parameters
    ----------
    settings : Settings
    config : str
        Name of the settings file.
    episodes : sequence of Episode
        At least one.

    Returns
    -------
    str
        One self-contained HTML page. The same input gives the same bytes.
    """
    again = ("reproduce", "How to reproduce this page", reproduce(settings, config))
    body = (
        single_episode(settings, episodes[0], again)
        if len(episodes) == 1
        else several_episodes(settings, episodes, again)
    )
    title = headline(episodes[0]) if len(episodes) == 1 else summary(episodes)
    head = tag(
        "head",
        tag("meta", charset="utf-8"),
        tag("meta", name_="viewport", content="width=device-width, initial-scale=1"),
        tag("meta", name_="color-scheme", content="light dark"),
        tag("title", f"{run_title(settings)}: {title}"),
        tag(
            "style",
            Html(
                read_text("trundle.report", "style.css") + read_text("trundle.experiments.runs", "style.css")
            ),
        ),
    )
    script = tag("script", Html(read_text(PACKAGE, "player.js")))
    return (
        "<!doctype html>\n"
        + tag("html", head, "\n", tag("body", tag("main", body), script), lang="en")
        + "\n"
    )


def single_episode(settings: Settings, episode: Episode, again: Part) -> list[Html]:
    """Return the page of one episode."""
    found = [*parts("e0", episode), again]
    links = contents([(identity, name) for identity, name, _ in found])
    return [answer("e0", episode, episode_title(settings, episode), links), *(part for *_, part in found)]


def several_episodes(settings: Settings, episodes: Sequence[Episode], again: Part) -> list[Html]:
    """Return the page of several episodes: an overview, then each episode."""
    names = [f"e{number}" for number in range(len(episodes))]
    links = contents([*((name, f"Episode {name[1:]}") for name in names), again[:2]])
    top = tag("header", tag("p", run_title(settings), class_="kicker"), tag("h1", summary(episodes)), links)
    body = [top, overview(names, episodes)]
    for name, episode in zip(names, episodes, strict=True):
        body.append(answer(name, episode, episode_title(settings, episode), None, "h2"))
        body += [part for *_, part in parts(name, episode)]
    return [*body, again[2]]


def overview(names: Sequence[str], episodes: Sequence[Episode]) -> Html:
    """Return the table of the episodes' outcomes."""
    rows = [
        [
            tag("a", f"seed {episode.seed}", href=f"#{name}"),
            "reached"
            if episode.outcome["is_success"]
            else "lost"
            if episode.outcome["lost"]
            else "time limit",
            format_seconds(episode.outcome["seconds"]),
            str(len(episode.updates)),
            format_quantity("m", episode.outcome["distance"]),
            ABSENT if episode.last is None else format_quantity("m", episode.off(episode.last)),
        ]
        for name, episode in zip(names, episodes, strict=True)
    ]
    head = ("", "goal", "after", "fits", "off the goal", "wheel off")
    return section("overview", "The episodes", table(head, rows, "overview"))


def episode_title(settings: Settings, episode: Episode) -> str:
    """Return environment and seed of an episode."""
    return f"{run_title(settings)}, seed {episode.seed}"


def run_title(settings: Settings) -> str:
    """Return the environment and its hidden physics."""
    hidden = settings.arguments.get("hidden")
    return f"Run of {settings.environment}" + (f', hidden="{hidden}"' if hidden else "")


def reproduce(settings: Settings, config: str) -> Html:
    """Return the command and the file that reproduce the page."""
    beside = (
        ("episode_NN/history.json", "motion, wrenches, beliefs and truth, machine-readable"),
        *((("episode_NN/recording/", "measurements"),) if settings.recording != "none" else ()),
        ("settings.json", "all settings of the run"),
    )
    return section(
        "reproduce",
        "How to reproduce this page",
        tag("pre", tag("code", f"trundle run {config} --out FOLDER")),
        tag("p", f"with trundle {__version__}, and in {config}:"),
        tag("pre", tag("code", settings.text.strip())),
        tag("p", "The same file and version give the same bytes. Other files of the run:"),
        tag("ul", [tag("li", tag("code", name), f" {what}") for name, what in beside]),
    )


def read_text(package: str, name: str) -> str:
    """Return a file of a package."""
    return resources.files(package).joinpath(name).read_text(encoding="utf-8")
