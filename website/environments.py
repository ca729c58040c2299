"""Pages of the environments, by the template of Gymnasium's documentation."""

from __future__ import annotations

import inspect
import io
from collections.abc import Iterator
from typing import Any

import gymnasium
import numpy as np
from PIL import Image

import trundle
from trundle.experiments.markdown import table

__all__ = ["TEMPLATE", "environment_ids", "environment_page", "environment_pages", "environment_pictures"]

NAMESPACE = "trundle"
EXTENDED, REPLACED = "base first", "most specific"
TEMPLATE = {
    "Description": EXTENDED,
    "Action Space": REPLACED,
    "Observation Space": EXTENDED,
    "Rewards": REPLACED,
    "Starting State": REPLACED,
    "Episode End": REPLACED,
    "Information": REPLACED,
    "Arguments": EXTENDED,
    "Version History": REPLACED,
    "Example": REPLACED,
}
"""Sections of a page, and how a class combines them with those of its bases: it extends or replaces them."""

PICTURE_SEED, PICTURE_STEPS = 4, 12
PICTURE_ACTION = (0.7, 0.1, 0.05)


def environment_ids() -> list[str]:
    """Return the ids of the newest version of each environment, in the order of registration."""
    newest = {spec.name: name for name, spec in gymnasium.registry.items() if spec.namespace == NAMESPACE}
    return list(newest.values())


def environment_pages() -> Iterator[tuple[str, str]]:
    """Yield path and text of the list of environments and of the page of each."""
    ids = environment_ids()
    yield "environments/index.md", index_page(ids)
    for name in ids:
        yield f"environments/{slug(name)}.md", environment_page(name)


def environment_pictures() -> Iterator[tuple[str, bytes]]:
    """Yield path and PNG of a picture of each environment."""
    for name in environment_ids():
        yield f"environments/{slug(name)}.png", picture(name)


def slug(name: str) -> str:
    """Return the name of the page of an environment."""
    return name.removeprefix(f"{NAMESPACE}/").rpartition("-v")[0].lower()


def index_page(ids: list[str]) -> str:
    """Return the list of environments."""
    rows = [[f"[`{name}`]({slug(name)}.md)", summary(environment_class(name))] for name in ids]
    return (
        "# Environments\n\n"
        "`import trundle` registers these environments with Gymnasium. "
        "[Push in simulation](../environments.md) describes hidden effects, batches, snapshots and "
        "scenarios.\n\n"
        f"{table(['id', 'task'], rows)}\n\n"
        "## Levels\n\n"
        "Training and test sets of all levels share no family of outlines, mass range or wheel layout. "
        "Masses are drawn log-uniformly. The office table, which is also the default of the adaptive agent, "
        "is in no test set.\n\n"
        f"{level_table()}\n"
    )


def level_table() -> str:
    """Return the table of training and test sets, which the native module defines."""
    head = ["level", "`split`", "outlines", "mass, kg", "wheels", "friction of a locked wheel, N s/m"]
    rows = [
        [
            level,
            split,
            ", ".join(outlines),
            f"{low:g} to {high:g}",
            ", ".join(wheels),
            f"{soft:g} to {hard:g}",
        ]
        for level, split, outlines, (low, high), wheels, (soft, hard) in trundle.envs.Push.OBJECT_SETS
    ]
    return table(head, rows)


def environment_page(name: str) -> str:
    """Return the page of an environment."""
    one = environment_class(name)
    env = gymnasium.make(name)
    facts = [
        ["action space", f"`{env.action_space}`"],
        ["observation space", space_text(env.observation_space)],
        ["make", f'`gymnasium.make("{name}")`'],
        ["batch", f'`gymnasium.make_vec("{name}", num_envs=1024)`'],
        [
            "class",
            f"[`trundle.envs.{one.__name__}`](../reference/python/envs.md#trundle.envs.{one.__name__})",
        ],
    ]
    env.close()
    parts = [
        f"# {name.removeprefix(NAMESPACE + '/').rpartition('-v')[0]}",
        summary(one),
        f'![{one.__name__} after a few steps]({slug(name)}.png){{ width="320" }}',
        table(["property", "value"], facts),
        *(f"## {title}\n\n{text}" for title, text in sections(one).items()),
    ]
    return "\n\n".join(parts) + "\n"


def environment_class(name: str) -> type[Any]:
    """Return the class of a registered environment."""
    creator = gymnasium.envs.registration.load_env_creator(str(gymnasium.spec(name).entry_point))
    assert isinstance(creator, type)
    return creator


def summary(one: type[Any]) -> str:
    """Return the first paragraph of a class's docstring."""
    return inspect.cleandoc(one.__doc__ or "").partition("\n\n")[0].replace("\n", " ")


def space_text(space: Any) -> str:
    """Return a space without its bounds, which the page tabulates."""
    if isinstance(space, gymnasium.spaces.Dict):
        return ", ".join(f"`{key}`: {space_text(part)}" for key, part in space.items())
    return f"`Box({space.shape}, {np.dtype(space.dtype).name})`"


def sections(one: type[Any]) -> dict[str, str]:
    """Return the sections of an environment's page.

    Raises
    ------
    ValueError
        If neither the class nor a base describes one of them.
    """
    documented = [own_sections(base) for base in one.__mro__ if issubclass(base, trundle.envs.Push)]
    merged = {}
    for title, rule in TEMPLATE.items():
        found = [part[title] for part in documented if title in part]
        if not found:
            raise ValueError(f"{one.__name__}: no section {title!r} in its docstring or in a base's")
        merged[title] = "\n\n".join(reversed(found)) if rule == EXTENDED else found[0]
    return merged


def own_sections(one: type[Any]) -> dict[str, str]:
    """Return the sections of a class's own docstring by title."""
    text = inspect.cleandoc(one.__dict__.get("__doc__") or "")
    parts = (part.partition("\n") for part in f"\n{text}".split("\n## ")[1:])
    return {title.strip(): content.strip() for title, _, content in parts}


def picture(name: str) -> bytes:
    """Return a picture of an environment after a few steps, as PNG."""
    env = gymnasium.make(name, render_mode="rgb_array")
    env.reset(seed=PICTURE_SEED)
    for _ in range(PICTURE_STEPS):
        env.step(np.array(PICTURE_ACTION, dtype=np.float32))
    pixels = np.asarray(env.render(), dtype=np.uint8)
    env.close()
    buffer = io.BytesIO()
    Image.fromarray(pixels).save(buffer, format="PNG", optimize=True)
    return buffer.getvalue()
