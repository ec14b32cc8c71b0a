"""Two machines in network namespaces, and what networks and strangers do to them. Every scenario prints its figures.

    scenarios.py PROGRAM [NAME ...]
"""

import json
import os
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from lab import HUB, ROBOT, WEARER, Lab

PROGRAM = str(Path(sys.argv[1]).resolve())
FINGER = ["--finger", "r1/left/index"]
PORT = 7450
QUIET = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}


def result(program, seconds=30):
    out, said = program.communicate(timeout=seconds)
    return (json.loads(out) if out.strip().startswith(("{", "[")) else None), said


def skin(lab, seconds, *more, at=None, scene="sphere-along"):
    at = at or ["--listen", f"{ROBOT}:{PORT}", "--plain"]
    words = ["skin", scene, *FINGER, "--json", "--seconds", str(seconds), *at, *more]
    return lab.start("robot", PROGRAM, *words, **QUIET)


def display(lab, seconds, *more, at=None, scene="sphere-along"):
    at = at or ["--connect", f"{ROBOT}:{PORT}", "--plain"]
    words = ["display", scene, *FINGER, "--json", "--seconds", str(seconds), *at, *more]
    return lab.start("wearer", PROGRAM, *words, **QUIET)


def check(right, text):
    if not right:
        raise AssertionError(text)


def monotonic_us(felt):
    """This machine's clock on that of the run."""
    return lambda seconds: seconds * 1e6 - felt["epoch_ns"] / 1e3


def pauses(felt, cuts):
    """Of every cut: from the newest reading until no output is on, from the cut's end to the next stimulus, ms."""
    to_run = monotonic_us(felt)
    figures = []
    for begun, ended in cuts:
        begun, ended = to_run(begun), to_run(ended)
        own = [p for p in felt["pauses"] if begun - 2e4 <= p["newest_us"] <= ended]
        off = [(p["off_us"] - p["newest_us"]) / 1e3 if p["off_us"] else 0.0 for p in own]
        back = [(p["back_us"] - ended) / 1e3 for p in own if p["back_us"]]
        figures.append((max(off, default=None), max(back, default=None)))
    return figures


def off_in_time(felt):
    """No output is on 100 ms after the newest reading: a turn comes once per millisecond, a transfer takes half of one."""
    late = [p["off_us"] - p["newest_us"] for p in felt["pauses"] if p["off_us"]]
    check(all(us <= 103_000 for us in late), f"off {late} us after the newest reading")


def added(felt, sent):
    """What the network added to a frame, ms: median and 99 %. Both clocks are this machine's, so their offset is known."""
    offset_us = (sent["epoch_ns"] - felt["epoch_ns"]) / 1e3
    more = (felt["offset_us"][1] - offset_us) / 1e3
    check(felt["offset_us"][0] - 1 <= offset_us <= felt["offset_us"][1] + 1, "the true offset is within its bounds")
    return felt["network_ms"]["median"] + more, felt["network_ms"]["p99"] + more


def quiet():
    """A bridge, and nothing else: contacts of a fingertip, and every scan of a hand of 15 modules."""
    for scene, send, rate in (("sphere-along", "contacts", 100), ("allegro-grasp", "scans", 1500)):
        with Lab() as lab:
            robot = skin(lab, 9, "--send", send, scene=scene)
            wearer = display(lab, 8, scene=scene)
            felt, said = result(wearer)
            sent, told = result(robot)
            median, p99 = added(felt, sent)
            print(f"  {scene}, {send}: {felt['frames']['felt']} of {sent['frames']}, {sent['bytes'] / sent['frames']:.0f} bytes each; "
                  f"added by the network {median:.2f} ms (median), {p99:.2f} ms (99 %); age at most {felt['age_ms']}")
            check(felt["frames"]["felt"] > 5 * rate and felt["frames"]["late"] == 0, f"{felt}{said}{told}")


def cuts():
    """A port is taken off the bridge: for 5 s; for 0.6 s and for 0.3 s."""
    # The scene lasts for 10 s: a cut heals while something is touched.
    for lengths in ((5.0,), (0.6, 0.3)):
        with Lab() as lab:
            robot, wearer = skin(lab, 11), display(lab, 10)
            time.sleep(3)
            made = []
            for length in lengths:
                begun = time.monotonic()
                lab.unplug("robot")
                time.sleep(length)
                lab.plug("robot")
                made.append((begun, time.monotonic()))
                time.sleep(1.6)
            felt, said = result(wearer)
            result(robot)
            print("  frames", felt["frames"])
            for (begun, ended), (off, back) in zip(made, pauses(felt, made)):
                print(f"  cut of {ended - begun:.2f} s: off {off} ms after the newest reading, back {back} ms after healing")
                check(off is not None and off <= 103, f"off after {off} ms: {felt}")
                check(back is not None and back <= 500, f"back after {back} ms: {felt}")


def weather():
    """Packets are delayed, lost, doubled and overtaken."""
    rows = [
        {"delay_ms": 5}, {"delay_ms": 20, "jitter_ms": 10, "loss": 0.01},
        {"delay_ms": 20, "jitter_ms": 10, "double": 0.1, "reorder": 0.2},
        {"delay_ms": 10, "loss": 0.1}, {"delay_ms": 10, "loss": 0.3}, {"delay_ms": 200},
    ]
    for row in rows:
        with Lab(row) as lab:
            robot, wearer = skin(lab, 11), display(lab, 10)
            felt, said = result(wearer)
            sent, _ = result(robot)
            age = felt["age_ms"] or {"median": None, "p99": None}
            print(f"  {row}: {felt['held']} felt of {sent['frames']}, {felt['frames']['late']} late, age {age['median']} ms, 99 % {age['p99']}, {len(felt['pauses'])} pauses")
            off_in_time(felt)
            if row["delay_ms"] >= 200:
                check(felt["held"] == 0 and felt["stimuli"] == 0, "a link that is too slow is not felt")
            elif row.get("loss", 0) <= 0.01:
                check(felt["held"] > 300, f"{felt}{said}")


def router():
    """Both find each other through a relay, which is killed: they need it no more."""
    relay = ["relay", "--listen", f"{HUB}:{PORT}", "--plain"]
    at = ["--connect", f"{HUB}:{PORT}", "--plain"]
    with Lab() as lab:
        first = lab.start("hub", PROGRAM, *relay, **QUIET)
        time.sleep(0.5)
        robot, wearer = skin(lab, 10, at=at), display(lab, 9, at=at)
        time.sleep(4)
        first.kill()
        first.wait()
        felt, said = result(wearer)
        _, told = result(robot)
        print(f"  relay killed: {felt['held']} felt, {len(felt['pauses'])} pauses")
        check(felt["held"] > 700 and not felt["pauses"], f"{felt}{said}{told}")


def keys(folder, *words):
    subprocess.run([PROGRAM, "keys", str(folder), *words], check=True, stdout=subprocess.DEVNULL)


def secure(folder, name, *words):
    return [*words, "--keys", str(folder / name)]


def security():
    """Certificates and the access list: members, a stranger of the lab, another lab, plain text, an expired certificate."""
    with tempfile.TemporaryDirectory() as own, tempfile.TemporaryDirectory() as other:
        own, other = Path(own), Path(other)
        keys(own, "--robot", "r1", "--robot", "r2", "--wearer", "w1=r1/*/*", "--watcher", "office")
        keys(other, "--robot", "r1", "--wearer", "w1")
        listen = ["--listen", f"{WEARER}:{PORT}"]
        connect = ["--connect", f"{WEARER}:{PORT}"]
        with Lab() as lab:
            wearer = display(lab, 22, at=secure(own, "w1", *listen))
            time.sleep(1)
            # In the lab, without the right.
            _, told = result(skin(lab, 2, at=secure(own, "r2", *connect)))
            check("may not publish" in told, told)
            print("  no right:", told.strip().splitlines()[-1][:120])
            # As above, with a list of its own that says otherwise: the wearer's list counts, and it is told.
            forged = own / "r2" / "access.toml"
            forged.write_text(forged.read_text().replace('"r2/*/*"', '"r1/*/*"', 1))
            _, told = result(skin(lab, 2, at=secure(own, "r2", *connect)))
            check("may not publish" in told and "access list of w1" in told, told)
            print("  own list forged:", told.strip().splitlines()[-1][:120])
            # Another lab: same names, another authority.
            stranger = skin(lab, 2, at=secure(other, "r1", *connect))
            _, told = result(stranger)
            print("  another lab:", (told.strip().splitlines() or ["(silence)"])[-1][:120])
            # Plain text against TLS.
            _, told = result(skin(lab, 2, at=[*connect, "--plain"]))
            print("  plain text:", (told.strip().splitlines() or ["(silence)"])[-1][:120])
            # A stranger listens.
            spy = lab.start("robot", PROGRAM, "list", "--json", *secure(other, "w1", *connect), **QUIET)
            seen, _ = result(spy)
            check(seen == [], f"a stranger sees {seen}")
            # And the true one.
            robot = skin(lab, 6, at=secure(own, "r1", *connect))
            time.sleep(3)
            listed, _ = result(lab.start("robot", PROGRAM, "list", "--json", *secure(own, "office", *connect), **QUIET))
            check(listed and listed[0]["wearers"] and listed[0]["wearers"][0]["wearer"] == "w1", f"{listed}")
            sent, told = result(robot)
            felt, said = result(wearer)
            print(f"  the robot: {felt['held']} felt of {sent['frames']}; not felt: {felt['frames']}")
            check(felt["held"] > 200, f"{felt}{said}{told}")
            check(felt["frames"]["second"] == 0, "nothing of a stranger reached the gate")
            check("another lab" in said or "stranger" in said, f"strangers are told: {said}")
        keys(own, "--robot", "r1", "--days", "0")
        with Lab() as lab:
            _, told = result(skin(lab, 2, at=secure(own, "r1", *connect)))
            check("counts from" in told, told)
            print("  expired:", told.strip().splitlines()[-1][:140])


def crowd():
    """1000 publishers beside ours, on the same bus."""
    script = (
        "import sys, time, zenoh\n"
        "config = zenoh.Config()\n"
        f"config.insert_json5('connect/endpoints', '[\"tcp/{ROBOT}:{PORT}\"]')\n"
        "config.insert_json5('scouting/multicast/enabled', 'false')\n"
        "session = zenoh.open(config)\n"
        "all = [session.declare_publisher(f'crowd/{n}/taxels') for n in range(1000)]\n"
        "end = time.monotonic() + float(sys.argv[1])\n"
        "sent = 0\n"
        "while time.monotonic() < end:\n"
        "    for one in all[sent % 10::10]:\n"
        "        one.put(bytes(100))\n"
        "    sent += 1\n"
        "    time.sleep(0.1)\n"
        "print(sent * 100)\n"
    )
    python = os.environ.get("LINK_PYTHON")
    if not python:
        print("  left out: LINK_PYTHON names no interpreter with eclipse-zenoh")
        return
    with Lab() as lab:
        robot, wearer = skin(lab, 11), display(lab, 10)
        others = lab.start("wearer", python, "-c", script, "8", **QUIET)
        felt, said = result(wearer)
        sent, _ = result(robot)
        out, told = others.communicate(timeout=20)
        print(f"  beside {out.strip()} messages of 1000 publishers: {felt['held']} felt of {sent['frames']}, age {felt['age_ms']}")
        check(felt["held"] > 500 and not felt["off_us"], f"{felt}{said}{told}")


def gigabyte():
    """A message of a gigabyte on our own key, and a flood of small ones."""
    script = (
        "import sys, time, zenoh\n"
        "config = zenoh.Config()\n"
        f"config.insert_json5('connect/endpoints', '[\"tcp/{WEARER}:{PORT}\"]')\n"
        "config.insert_json5('scouting/multicast/enabled', 'false')\n"
        "session = zenoh.open(config)\n"
        "one = session.declare_publisher('palpate/r1/left/index/contacts')\n"
        "time.sleep(1)\n"
        "end = time.monotonic() + 3\n"
        "count = 0\n"
        "while time.monotonic() < end:\n"
        "    one.put(bytes(90)); count += 1\n"
        "one.put(bytes(1 << 30))\n"
        "time.sleep(3)\n"
        "print(count)\n"
    )
    python = os.environ.get("LINK_PYTHON")
    if not python:
        print("  left out: LINK_PYTHON names no interpreter with eclipse-zenoh")
        return
    with Lab() as lab:
        wearer = display(lab, 14, at=["--listen", f"{WEARER}:{PORT}", "--plain"])
        robot = skin(lab, 14, at=["--connect", f"{WEARER}:{PORT}", "--plain"])
        time.sleep(3)
        flood = lab.start("robot", python, "-c", script, **QUIET)
        most = 0
        child = subprocess.run(["pgrep", "-P", str(wearer.pid)], capture_output=True, text=True).stdout.split()
        pid = child[0] if child else str(wearer.pid)
        while wearer.poll() is None:
            try:
                status = Path(f"/proc/{pid}/status").read_text()
            except OSError:
                break
            for line in status.splitlines():
                if line.startswith("VmRSS"):
                    most = max(most, int(line.split()[1]))
            time.sleep(0.05)
        felt, said = result(wearer)
        sent, _ = result(robot)
        out, _ = flood.communicate(timeout=20)
        print(f"  after {out.strip()} small ones and a gigabyte: {felt['held']} felt of {sent['frames']}, {felt['overflowed']} found no room, {felt['damaged']} damaged, at most {most // 1024} MB of memory, {len(felt['pauses'])} pauses")
        check(most < 300_000, f"{most} kB of memory")
        check(felt["held"] > 300, f"{felt}{said}")


def many():
    """8 robots and 8 wearers on this machine."""
    with Lab() as lab:
        pairs = []
        for n in range(8):
            robot = ["skin", "sphere-along", "--finger", f"r{n}/left/index", "--json", "--seconds", "12",
                     "--listen", f"{ROBOT}:{PORT + n}", "--plain"]
            wearer = ["display", "sphere-along", "--finger", f"r{n}/left/index", "--json", "--seconds", "10",
                      "--connect", f"{ROBOT}:{PORT + n}", "--plain", "--wearer", f"w{n}"]
            pairs.append((lab.start("robot", PROGRAM, *robot, **QUIET), lab.start("wearer", PROGRAM, *wearer, **QUIET)))
        begun = os.times()
        results = [(result(robot, 40), result(wearer, 40)) for robot, wearer in pairs]
        ended = os.times()
        ages = sorted(wearer[0]["age_ms"]["p99"] for _, wearer in results)
        held = [wearer[0]["held"] for _, wearer in results]
        off = sum(len(wearer[0]["pauses"]) for _, wearer in results)
        cpu = (ended.children_user - begun.children_user) + (ended.children_system - begun.children_system)
        print(f"  felt {held}, worst 99 % of age {ages[-1]} ms, {off} pauses, {cpu:.1f} s of processor for 8 pairs of about 11 s")
        check(min(held) > 500, f"{held}")


SCENARIOS = {f.__name__: f for f in (quiet, cuts, weather, router, security, crowd, gigabyte, many)}

if __name__ == "__main__":
    signal.alarm(600)
    if shutil.which("ip") is None:
        sys.exit("link: expected iproute2")
    for name in sys.argv[2:] or SCENARIOS:
        print(f"link: {name}: {SCENARIOS[name].__doc__.splitlines()[0]}", flush=True)
        SCENARIOS[name]()
