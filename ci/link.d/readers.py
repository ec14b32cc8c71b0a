"""Readers that are not ours: what `palpate-link` publishes and records, read by rosbags, zenoh-ros2-sdk, eclipse-zenoh and mcap.

    readers.py FOLDER_OF_PROGRAMS
"""

import json
import signal
import socket
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import zenoh
from recordings import messages
from rosbags.typesys import Stores, get_typestore

PROGRAM, HIL = (str(Path(sys.argv[1]).resolve() / name) for name in ("palpate-link", "hil"))
FINGER = ["--finger", "r1/left/index"]
EXAMPLE = Path(__file__).resolve().parents[2] / "hil/link/examples/contacts.py"
POINT, MARKERS = "geometry_msgs/msg/PointStamped", "visualization_msgs/msg/MarkerArray"


def port():
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        return f"127.0.0.1:{free.getsockname()[1]}"


def start(*words):
    return subprocess.Popen([PROGRAM, *words], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)


def session_at(address):
    text = f'{{mode: "peer", connect: {{endpoints: ["tcp/{address}"]}}, scouting: {{multicast: {{enabled: false}}}}}}'
    return zenoh.open(zenoh.Config.from_json5(text))


def example(address, folder):
    """Ten lines of Python read the contacts."""
    descriptor = folder / "link.desc"
    descriptor.write_bytes(subprocess.run([PROGRAM, "schema", "--binary"], check=True, capture_output=True).stdout)
    reader = subprocess.Popen([sys.executable, EXAMPLE, descriptor, address], stdout=subprocess.PIPE, text=True)
    lines = [reader.stdout.readline() for _ in range(100)]
    reader.kill()
    reader.wait()
    assert all(line.startswith("palpate/r1/left/index/contacts ") for line in lines), lines[:3]
    print(f"readers: contacts.py: {len(lines)} contacts, such as {lines[0].strip()}")


def bags(address):
    """rosbags has the same hashes, and what it makes of a message is the same bytes again."""
    types = get_typestore(Stores.ROS2_JAZZY)
    seen = {}
    with session_at(address) as session:
        def take(sample):
            seen.setdefault(str(sample.key_expr), []).append((bytes(sample.payload), bytes(sample.attachment)))
        subscriber = session.declare_subscriber("0/palpate/**", take)
        time.sleep(3)
        subscriber.undeclare()
    for kind in (POINT, MARKERS):
        package, _, name = kind.split("/")
        topic = "contact" if kind == POINT else "markers"
        key = f"0/palpate/r1/left/index/{topic}/{package}::msg::dds_::{name}_/{types.hash_rihs01(kind)}"
        messages = seen.get(key, [])
        assert len(messages) > 100, f"{key}: {len(messages)}; there is {list(seen)}"
        for number, (payload, attachment) in enumerate(messages):
            message = types.deserialize_cdr(payload, kind)
            assert bytes(types.serialize_cdr(message, kind)) == payload, f"{kind} {number}"
            assert len(attachment) == 33 and attachment[16] == 16
        if kind == POINT:
            assert all(abs(getattr(message.point, axis)) < 0.02 for axis in "xyz"), message
            assert abs(message.header.stamp.sec - time.time()) < 60
        print(f"readers: rosbags: {len(messages)} {name}, the same bytes again")


def sdk(address):
    """zenoh-ros2-sdk subscribes as a node of ROS would."""
    from zenoh_ros2_sdk import ROS2Subscriber

    types = get_typestore(Stores.ROS2_JAZZY)
    definition, _ = types.generate_msgdef(POINT)
    host, number = address.split(":")
    seen = []
    subscriber = ROS2Subscriber(
        topic="/palpate/r1/left/index/contact", msg_type=POINT, callback=seen.append,
        msg_definition=definition, type_hash=types.hash_rihs01(POINT), domain_id=0,
        router_ip=host, router_port=int(number),
    )
    time.sleep(3)
    subscriber.close()
    assert len(seen) > 100, len(seen)
    assert all(abs(message.point.x) < 0.02 for message in seen)
    print(f"readers: zenoh-ros2-sdk: {len(seen)} messages")


def recording(folder, file):
    """The mcap package reads a recording, protobuf its messages."""
    count, facts = {}, {}
    for topic, _, message in messages(folder / file):
        if topic is None:
            facts = message
        else:
            count[topic] = count.get(topic, 0) + 1
    print(f"readers: mcap: {file}: {sum(count.values())} messages on {len(count)} topics, {facts.get('palpate-link')}")
    return count


def main():
    signal.alarm(180)
    with tempfile.TemporaryDirectory() as folder:
        folder = Path(folder)
        address = port()
        relay = start("relay", "--listen", address)
        robot = start("skin", "sphere-along", *FINGER, "--seconds", "40", "--quiet", "--connect", address,
                      "--record", str(folder / "robot.mcap"))
        ros = start("ros", *FINGER, "--connect", address)
        wearer = start("display", "sphere-along", *FINGER, "--quiet", "--connect", address, "--seconds", "8",
                       "--record", str(folder / "wearer.mcap"))
        watcher = start("record", str(folder / "bus.mcap"), "--connect", address, "--seconds", "6")
        time.sleep(2)
        try:
            example(address, folder)
            bags(address)
            sdk(address)
            _, said = watcher.communicate(timeout=20)
            bus = recording(folder, "bus.mcap")
            assert bus.get("/palpate/r1/left/index/contacts", 0) > 200, (bus, said)
            _, said = wearer.communicate(timeout=20)
            assert wearer.returncode == 0, said
            robot.send_signal(signal.SIGINT)
            _, said = robot.communicate(timeout=10)
            assert robot.returncode == 0, said
            merged = subprocess.run([PROGRAM, "merge", folder / "robot.mcap", folder / "wearer.mcap", "--out", folder / "both.mcap",
                                     "--contacts", folder / "contacts", "--json"],
                                    capture_output=True, text=True)
            assert merged.returncode == 0, merged.stderr
            merged = json.loads(merged.stdout)
            both = recording(folder, "both.mcap")
            assert both["/robot/contacts"] > 500 and both["/wearer/contacts"] > 300 and both["/wearer/felt"] > 20, both
            assert merged["reading_us"] <= 2 * merged["uncertainty_us"] + 1000, merged
            print("readers: merge:", merged)
            # Every frame of the wearer is one of the robot's; what is told is what it did not feel.
            assert merged["frames_same"] > 300, merged
            told = subprocess.run([HIL, "diff", folder / "contacts" / "robot.csv", folder / "contacts" / "wearer.csv"],
                                  capture_output=True, text=True)
            print("readers: hil diff:", *told.stdout.strip().splitlines()[:3], sep="\n  ")
            assert told.returncode == 1 and " mm " not in told.stdout, told
        finally:
            for program in (relay, robot, ros, wearer, watcher):
                program.kill()
                program.wait()


if __name__ == "__main__":
    main()
