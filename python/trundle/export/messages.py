"""Writing of ROS 2 messages to a bag."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from trundle._optional import require
from trundle.export.markers import MARKERS, TRANSFORMS, marker_array, transforms
from trundle.importers.trundle_mcap import NUMBER, STRING

if TYPE_CHECKING:
    from rosbags.interfaces import Qos
    from rosbags.rosbag2 import Writer

__all__ = ["NS_PER_S", "Bag"]

NS_PER_S = 10**9


class Bag:
    """A bag for writing. A topic is created with its first message.

    Parameters
    ----------
    writer : Writer
        An open writer.
    """

    def __init__(self, writer: Writer) -> None:
        self._writer = writer
        types = require("rosbags.typesys", "ros", "MCAP files")
        self._store = types.get_typestore(types.Stores.LATEST)
        self._connections: dict[str, Any] = {}

    def write(
        self, topic: str, kind: str, stamp: int, content: Any, frame: str = "", *, latched: bool = False
    ) -> None:
        """Write a message.

        Parameters
        ----------
        topic, kind : str
            Name and message type of the topic.
        stamp : int
            Stamp of the header and log time, ns.
        content : str, list of float, (str, list of float) or list of Marker
            A string, one number, six numbers of a wrench, or seven of a pose: x, y, z, qw, qx, qy, qz. Of a
            transform the child frame and its pose; of a marker array a list of `Marker`.
        frame : str
            `frame_id` of the header.
        latched : bool
            Whether players deliver the message to late subscribers.
        """
        if topic not in self._connections:
            self._connections[topic] = self._writer.add_connection(
                topic, kind, typestore=self._store, offered_qos_profiles=[latched_qos()] if latched else []
            )
        data = self._store.serialize_cdr(self._message(kind, stamp, content, frame), kind)
        self._writer.write(self._connections[topic], stamp, data)

    def _message(self, kind: str, stamp: int, content: Any, frame: str) -> Any:
        make = self._store.types
        if kind == STRING:
            return make[kind](content)
        if kind == NUMBER:
            return make[kind](*content)
        time = make["builtin_interfaces/msg/Time"](*divmod(stamp, NS_PER_S))
        if kind == MARKERS:
            return marker_array(make, time, content)
        header = make["std_msgs/msg/Header"](time, frame)
        if kind == TRANSFORMS:
            return transforms(make, header, *content)
        if kind == "geometry_msgs/msg/WrenchStamped":
            vector = make["geometry_msgs/msg/Vector3"]
            wrench = make["geometry_msgs/msg/Wrench"](vector(*content[:3]), vector(*content[3:]))
            return make[kind](header, wrench)
        x, y, z, qw, qx, qy, qz = content
        turn = make["geometry_msgs/msg/Quaternion"](qx, qy, qz, qw)
        return make[kind](
            header, make["geometry_msgs/msg/Pose"](make["geometry_msgs/msg/Point"](x, y, z), turn)
        )


def latched_qos() -> Qos:
    """Return the quality of service of a topic whose last message late subscribers receive."""
    interfaces = require("rosbags.interfaces", "ros", "MCAP files")
    forever = interfaces.QosTime(9223372036, 854775807)
    qos: Qos = interfaces.Qos(
        history=interfaces.QosHistory.KEEP_LAST,
        depth=1,
        reliability=interfaces.QosReliability.RELIABLE,
        durability=interfaces.QosDurability.TRANSIENT_LOCAL,
        deadline=forever,
        lifespan=forever,
        liveliness=interfaces.QosLiveliness.AUTOMATIC,
        liveliness_lease_duration=forever,
        avoid_ros_namespace_conventions=False,
    )
    return qos
