"""Two machines and what lies between them, as network namespaces of this one: a bridge with ports that can be taken off, or
a wire that delays, loses, doubles and reorders packets. Where PALPATE_LINK_NETEM is set, that wire is the kernel's own netem
on a bridge. Everything is torn down at the end. No address but theirs is used."""

import fcntl
import heapq
import json
import os
import random
import select
import signal
import socket
import struct
import subprocess
import sys
import time
from pathlib import Path

ROBOT, WEARER, HUB = "10.77.31.1", "10.77.31.2", "10.77.31.3"
# Where the two have no way to each other: the hub is in both networks, and forwards nothing between them.
WEARER_APART, HUB_APART = "10.77.32.2", "10.77.32.3"


def ip(*words):
    subprocess.run(["ip", *words], check=True)


def without_offload(device):
    """Packets carry whole checksums then, and none is longer than the wire's own."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        for command in (0x17, 0x1F, 0x24):  # ETHTOOL_STXCSUM, _STSO, _SGSO
            value = bytearray(struct.pack("II", command, 0))
            address = (struct.unpack("L", struct.pack("P", id_of(value)))[0])
            fcntl.ioctl(probe, 0x8946, struct.pack("16sP", device.encode(), address))


def id_of(buffer):
    import ctypes

    return ctypes.addressof((ctypes.c_char * len(buffer)).from_buffer(buffer))


class Lab:
    """Namespaces `robot` and `wearer`, and `hub` between them."""

    def __init__(self, weather=None, apart=False):
        self.prefix = f"pl{os.getpid()}"
        self.programs = []
        self.wire = None
        for name in ("robot", "wearer", "hub"):
            ip("netns", "add", self.space(name))
            self.inside(name, "ip", "link", "set", "dev", "lo", "up")
        for name, address in (("robot", ROBOT), ("wearer", WEARER_APART if apart else WEARER)):
            ip("link", "add", "port", "netns", self.space(name), "type", "veth",
               "peer", "name", f"to-{name}", "netns", self.space("hub"))
            self.inside(name, "ip", "address", "add", f"{address}/24", "dev", "port")
            self.inside(name, "ip", "link", "set", "dev", "port", "up")
            self.inside("hub", "ip", "link", "set", "dev", f"to-{name}", "up")
        if apart:
            for name, address in (("robot", HUB), ("wearer", HUB_APART)):
                self.inside("hub", "ip", "address", "add", f"{address}/24", "dev", f"to-{name}")
            self.inside("hub", sys.executable, "-c", "open('/proc/sys/net/ipv4/ip_forward', 'w').write('0')")
        elif weather is None or "PALPATE_LINK_NETEM" in os.environ:
            self.inside("hub", "ip", "link", "add", "name", "bridge", "type", "bridge")
            self.inside("hub", "ip", "address", "add", f"{HUB}/24", "dev", "bridge")
            self.inside("hub", "ip", "link", "set", "dev", "bridge", "up")
            for name in ("robot", "wearer"):
                self.plug(name)
                if weather is not None:
                    self.inside("hub", "tc", "qdisc", "add", "dev", f"to-{name}", "root", "netem", *netem(weather))
        else:
            for name in ("robot", "wearer"):
                self.inside(name, sys.executable, __file__, "offload", "port")
            self.wire = self.start("hub", sys.executable, __file__, "wire", json.dumps(weather))

    def space(self, name):
        return f"{self.prefix}-{name}"

    def words(self, name, *words):
        return ["ip", "netns", "exec", self.space(name), *words]

    def inside(self, name, *words):
        subprocess.run(self.words(name, *words), check=True)

    def start(self, name, *words, **options):
        program = subprocess.Popen(self.words(name, *words), text=True, **options)
        self.programs.append(program)
        return program

    def reaches(self, name, address):
        """Whether a machine has a way to an address: a datagram leaves it."""
        words = f"import socket; socket.socket(socket.AF_INET, socket.SOCK_DGRAM).connect(('{address}', 9))"
        return subprocess.run(self.words(name, sys.executable, "-c", words), stderr=subprocess.DEVNULL).returncode == 0

    def plug(self, name):
        self.inside("hub", "ip", "link", "set", "dev", f"to-{name}", "master", "bridge")

    def unplug(self, name):
        """Silent: both ends keep their link, and nothing comes."""
        self.inside("hub", "ip", "link", "set", "dev", f"to-{name}", "nomaster")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        for program in self.programs:
            if program.poll() is None:
                program.kill()
            program.wait()
        for name in ("robot", "wearer", "hub"):
            subprocess.run(["ip", "netns", "del", self.space(name)], check=False)


def netem(weather):
    """The same weather in netem's words. A packet that it takes out of its turn is sent at once, and one whose delay is drawn
    shorter than that of the one before overtakes it."""
    words = ["limit", "10000", "delay", f"{weather['delay_ms']}ms", f"{weather.get('jitter_ms', 0)}ms"]
    for share, word in (("loss", "loss"), ("double", "duplicate"), ("reorder", "reorder")):
        if share in weather:
            words += [word, f"{100 * weather[share]:g}%"]
    return words


def wire(weather):
    """Hands packets between two ports, as the weather has it: delay_ms, jitter_ms, loss, double, reorder (shares)."""
    dice = random.Random(weather.get("seed", 1))
    ports = []
    for name in ("to-robot", "to-wearer"):
        without_offload(name)
        port = socket.socket(socket.AF_PACKET, socket.SOCK_RAW, socket.htons(3))
        port.bind((name, 0))
        # What this program sends comes back otherwise.
        port.setsockopt(263, 23, 1)  # SOL_PACKET, PACKET_IGNORE_OUTGOING
        ports.append(port)
    delay, jitter = weather["delay_ms"] / 1000, weather.get("jitter_ms", 0) / 1000
    flying, count, latest = [], 0, [0.0, 0.0]
    while True:
        now = time.monotonic()
        while flying and flying[0][0] <= now:
            _, _, to, packet = heapq.heappop(flying)
            try:
                ports[to].send(packet)
            except OSError:
                pass  # a port that is gone
        wait = max(0, flying[0][0] - now) if flying else None
        ready, _, _ = select.select(ports, [], [], wait)
        for port in ready:
            packet = port.recv(65536)
            to = 1 - ports.index(port)
            if dice.random() < weather.get("loss", 0):
                continue
            for _ in range(2 if dice.random() < weather.get("double", 0) else 1):
                at = time.monotonic() + delay + dice.uniform(-jitter, jitter)
                if dice.random() >= weather.get("reorder", 0):
                    at = max(at, latest[to])
                    latest[to] = at
                count += 1
                heapq.heappush(flying, (at, count, to, packet))


if __name__ == "__main__":
    signal.signal(signal.SIGINT, signal.SIG_DFL)
    if sys.argv[1] == "offload":
        without_offload(sys.argv[2])
    elif sys.argv[1] == "wire":
        wire(json.loads(sys.argv[2]))
