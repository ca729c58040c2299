"""The reference of the command line, from the parsers of its verbs."""

from __future__ import annotations

import argparse

from trundle.cli import build_parser
from trundle.cli.commands import discover

__all__ = ["command_page", "verb_section"]


def command_page() -> str:
    """Return the page with the help of every verb."""
    commands = discover()
    parser = build_parser(commands)
    (verbs,) = (action for action in parser._actions if isinstance(action, argparse._SubParsersAction))
    summary = "\n".join(f"| [`{name}`](#trundle-{name}) | {one.HELP} |" for name, one in commands.items())
    parts = [
        "# Command line",
        f"{parser.description} `trundle VERB --help` prints the same text.",
        f"| verb | purpose |\n| --- | --- |\n{summary}",
        "| exit status | meaning |\n| --- | --- |\n| 0 | the verb answered |\n| 1 | other failure |\n"
        "| 2 | the input or the arguments cannot be used; the reason is on standard error |\n"
        "| 130 | interrupted |",
        "`TRUNDLE_DEBUG=1` prints the traceback of an error.",
        *(verb_section(name, verbs.choices[name], commands[name]) for name in commands),
    ]
    return "\n\n".join(parts) + "\n"


def verb_section(name: str, parser: argparse.ArgumentParser, command: object) -> str:
    """Return the section of a verb: purpose, usage, arguments and example."""
    usage = parser.format_usage().removeprefix("usage: ").strip()
    parts = [f"## trundle {name}", str(parser.description), f"```text\n{usage}\n```"]
    rows = [
        f"| {invocation(action)} | {meaning(action, parser)} |"
        for action in parser._actions
        if not isinstance(action, argparse._HelpAction)
    ]
    if rows:
        parts.append("\n".join(["| argument | meaning |", "| --- | --- |", *rows]))
    example = getattr(command, "EXAMPLE", None)
    if example:
        parts.append(f"```bash\n{example}\n```")
    return "\n\n".join(parts)


def invocation(action: argparse.Action) -> str:
    """Return how an argument is written, for a cell of a table."""
    shown = argparse.HelpFormatter("")._format_action_invocation(action)
    return f"`{escaped(shown)}`"


def meaning(action: argparse.Action, parser: argparse.ArgumentParser) -> str:
    """Return the help of an argument with its values in place of the formats, for a cell of a table."""
    text = argparse.HelpFormatter(parser.prog)._expand_help(action) if action.help else ""
    return escaped(text).replace("<", "&lt;")


def escaped(content: str) -> str:
    """Return text without the characters that end a cell or a row of a table."""
    return content.replace("|", "\\|").replace("\n", " ")
