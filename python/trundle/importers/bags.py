"""Access to ROS 2 bags: a bare `.mcap` or `.db3`, a rosbag2 folder, or a folder of several."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from trundle._optional import require
from trundle.importers.config import MapError
from trundle.importers.layout import ShowProgress, SourceError

if TYPE_CHECKING:
    from rosbags.rosbag2 import Reader

__all__ = ["check_topic", "list_bags", "messages", "open_bag"]

MESSAGES_PER_PROGRESS = 20_000
"""Number of messages between two progress reports."""


def list_bags(source: Path) -> list[Path]:
    """Return the bags of a source in the order of their names."""
    if source.suffix == ".bag":
        raise SourceError(source, "a ROS 1 bag; convert it with `rosbags-convert --src IN.bag --dst OUT`")
    if source.is_file() or (source / "metadata.yaml").is_file():
        return [source]
    inside = sorted(
        path
        for path in source.iterdir()
        if path.suffix in (".mcap", ".db3") or (path / "metadata.yaml").is_file()
    )
    if not inside:
        raise SourceError(source, "no bag: neither metadata.yaml nor any .mcap, .db3 or bag folder inside")
    return inside


@contextmanager
def open_bag(bag: Path) -> Iterator[Reader]:
    """Open a bag for reading; the error for a damaged bag names a remedy."""
    rosbag2 = require("rosbags.rosbag2", "ros", "ROS bags")
    try:
        with rosbag2.Reader(bag) as reader:
            yield reader
    except (SourceError, MapError, OSError):
        raise
    except KeyError as error:
        remedy = "copy the ROS 2 topics to another bag with `mcap filter IN -o OUT -y TOPIC`"
        raise SourceError(
            bag, f"contains channels that are not ROS 2 messages ({error}); {remedy}"
        ) from error
    except Exception as error:
        # For a damaged file the library may raise any exception.
        remedy = "recover it with `mcap recover IN -o OUT` or `ros2 bag reindex FOLDER`"
        raise SourceError(bag, f"damaged bag ({type(error).__name__}: {error}); {remedy}") from error


def messages(bag: Path, reader: Reader, topics: Collection[str], say: ShowProgress) -> Iterator[Any]:
    """Yield topic, type, log time in ns and message of all messages on some topics, in the order of the log.

    Types outside the common interfaces of ROS 2 are those that the bag defines.
    """
    types = require("rosbags.typesys", "ros", "ROS bags")
    store = types.get_typestore(types.Stores.LATEST)
    connections = [connection for connection in reader.connections if connection.topic in topics]
    for connection in connections:
        if connection.msgtype not in store.types:
            if not connection.msgdef.data:
                raise SourceError(
                    bag,
                    f"does not define the type {connection.msgtype} of {connection.topic}; record with "
                    "`ros2 bag record --storage mcap`, which stores definitions",
                )
            found = types.get_types_from_msg(connection.msgdef.data, connection.msgtype)
            store.register({name: each for name, each in found.items() if name not in store.types})
    for count, (connection, stamp, data) in enumerate(reader.messages(connections=connections)):
        if count % MESSAGES_PER_PROGRESS == 0:
            say(f"{bag.name}: {count} messages")
        message = store.deserialize_cdr(data, connection.msgtype)
        yield connection.topic, connection.msgtype, stamp, message


def check_topic(bag: Path, reader: Reader, role: str, topic: str, kinds: Collection[str]) -> str:
    """Return the type of a topic; refuse an absent topic, and a type that is not in `kinds`."""
    types = {connection.topic: connection.msgtype for connection in reader.connections}
    listing = ", ".join(f"{name} ({kind})" for name, kind in sorted(types.items())) or "none"
    if topic not in types:
        raise SourceError(bag, f"no topic {topic!r} for {role}; the topics are: {listing}")
    kind = types[topic]
    if kind not in kinds:
        raise SourceError(
            bag, f"topic {topic} for {role} has the type {kind}; it must be one of {', '.join(kinds)}"
        )
    return kind
