"""Reads every message of an MCAP file with mcap_ros2 and with rosbags, and follows the paths that layouts name.

Prints one JSON document: how many messages each topic has, the first message of each topic, and the paths that lead
nowhere."""

import json
import math
import sys
from pathlib import Path
from xml.etree import ElementTree

from mcap_ros2.reader import read_ros2_messages
from rosbags.highlevel import AnyReader
from rosbags.typesys import Stores, get_types_from_msg, get_typestore


def as_json(message):
    if hasattr(message, "__slots__"):
        return {name: as_json(getattr(message, name)) for name in message.__slots__ if name[0] != "_"}
    if isinstance(message, (list, tuple)):
        return [as_json(part) for part in message]
    if isinstance(message, float) and not math.isfinite(message):
        return None
    return message.hex() if isinstance(message, bytes) else message


def with_mcap_ros2(file):
    counts, first, stamps = {}, {}, {}
    for message in read_ros2_messages(file):
        topic = message.channel.topic
        counts[topic] = counts.get(topic, 0) + 1
        if topic not in first:
            first[topic] = as_json(message.ros_msg)
            stamps[topic] = message.log_time_ns
    return counts, first, stamps


def with_rosbags(file):
    """Counts by topic. What ROS 2 has itself must be defined as in its distribution Humble."""
    humble, counts = get_typestore(Stores.ROS2_HUMBLE), {}
    with AnyReader([Path(file)]) as reader:
        for connection in reader.connections:
            types = get_types_from_msg(connection.msgdef.data, connection.msgtype)
            for name, fields in types.items():
                assert name.startswith("softdock/") or humble.fielddefs[name] == fields, name
        for connection, _, raw in reader.messages():
            reader.deserialize(raw, connection.msgtype)
            counts[connection.topic] = counts.get(connection.topic, 0) + 1
    return counts


def foxglove_paths(text):
    panels = json.loads(text)["configById"].values()
    for panel in panels:
        yield from (path["value"] for path in panel.get("paths", []))
        yield from panel.get("topics", {})


def plotjuggler_paths(text):
    yield from (curve.get("name") for curve in ElementTree.fromstring(text).iter("curve"))


def exists(path, messages, separator):
    topics = [topic for topic in messages if path == topic or path.startswith(topic + separator)]
    if not topics:
        return False
    topic = max(topics, key=len)
    value = messages[topic]
    for name in path[len(topic) :].split(separator)[1:]:
        if not isinstance(value, dict) or name not in value:
            return False
        value = value[name]
    return path == topic or not isinstance(value, (dict, list, str))


file, *layouts = sys.argv[1:]
counts, first, stamps = with_mcap_ros2(file)
assert with_rosbags(file) == counts
missing, followed = [], 0
for layout in layouts:
    text = Path(layout).read_text()
    paths, separator = (foxglove_paths(text), ".") if layout.endswith(".json") else (plotjuggler_paths(text), "/")
    for path in paths:
        followed += 1
        if not exists(path, first, separator):
            missing.append(path)
print(json.dumps({"counts": counts, "first": first, "stamps": stamps, "followed": followed, "missing": missing}))
