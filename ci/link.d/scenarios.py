"""Two machines in network namespaces, and what networks and strangers do to them. Every scenario prints its figures.

    scenarios.py FOLDER_OF_PROGRAMS [NAME ...]
"""

import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from ends import FINGER, HIL, PORT, PROGRAM, QUIET, added, check, display, keys, off_in_time, pauses, processor_s, result, secure, skin, through
from lab import HUB, HUB_APART, ROBOT, WEARER, WEARER_APART, Lab
from recordings import Recording, felt_error, messages, scale_of


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


def clocks():
    """Machines that count time from elsewhere: one end's clock is ten hours ahead, in a time namespace of its own."""
    ahead_s = 36000
    under = ["unshare", "--time", "--fork", "--kill-child", "--monotonic", str(ahead_s)]
    for end, sign in (("robot", -1), ("wearer", 1)):
        with Lab() as lab:
            robot = skin(lab, 7, under=under if end == "robot" else ())
            wearer = display(lab, 6, under=under if end == "wearer" else ())
            felt, said = result(wearer)
            sent, told = result(robot)
            median, p99 = added(felt, sent, sign * ahead_s)
            print(f"  the {end}'s clock ten hours ahead: {felt['held']} felt of {sent['frames']}, none late: {felt['frames']['late'] == 0}; "
                  f"the other's is known to {felt['offset_us'][1] - felt['offset_us'][0]} us; added by the network {median:.2f} ms (median), {p99:.2f} ms (99 %)")
            check(felt["held"] > 300 and felt["frames"]["late"] == 0 and not felt["pauses"], f"{felt}{said}{told}")


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


def often():
    """100 cuts of 0.1 to 0.6 s in two minutes, of a finger that is touched all the time."""
    dice = random.Random(31)
    with Lab() as lab:
        robot, wearer = skin(lab, 131, "--set", "length_s=200"), display(lab, 130, "--set", "length_s=200")
        time.sleep(3)
        made = []
        for _ in range(100):
            begun = time.monotonic()
            lab.unplug("robot")
            time.sleep(dice.uniform(0.1, 0.6))
            lab.plug("robot")
            made.append((begun, time.monotonic()))
            time.sleep(dice.uniform(0.6, 0.9))
        felt, said = result(wearer, 60)
        sent, _ = result(robot, 60)
        off = sorted(f[0] for f in pauses(felt, made) if f[0] is not None)
        back = sorted(f[1] for f in pauses(felt, made) if f[1] is not None)
        print(f"  {len(made)} cuts, {len(off)} of them felt: off {off[len(off) // 2]:.0f} ms (median), {off[-1]:.0f} ms (most) after the newest reading; "
              f"back {back[len(back) // 2]:.0f} ms (median), {back[-1]:.0f} ms (most) after healing; {felt['held']} felt of {sent['frames']}")
        off_in_time(felt)
        check(len(off) > 80 and back[-1] <= 500, f"{back[-5:]}{said}")


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


def felt():
    """The felt path by scene and person, against where the robot was touched at that moment: wired, over a bridge, behind a far
    network. Both clocks are this machine's."""
    with tempfile.TemporaryDirectory() as folder:
        wired, robot, wearer = (str(Path(folder) / f"{name}.mcap") for name in ("wired", "robot", "wearer"))
        subprocess.run([HIL, "run", "sphere-along", "--record", wired, "--quiet"], check=True)
        wired = Recording(wired)
        scale = scale_of(wired)
        best, count = felt_error(wired, wired, 0.0, scale)
        print(f"  wired: {best:.3f} mm RMSE of {count} onsets")
        far = {"delay_ms": 20, "jitter_ms": 10, "loss": 0.01}
        for name, row, more in (("a bridge", None, []), ("20 +- 10 ms, 1 % lost", far, []), ("the same over one connection", far, ["--once"])):
            with Lab(row) as lab:
                # The wearer is there first, so that it feels the scene from its beginning.
                away = display(lab, 13, "--record", wearer, "--force", *more, at=["--listen", f"{WEARER}:{PORT}", "--plain"])
                time.sleep(0.5)
                here = skin(lab, 10, "--record", robot, "--force", *more, at=["--connect", f"{WEARER}:{PORT}", "--plain"])
                sent, told = result(here)
                got, said = result(away)
            ahead_s = (sent["epoch_ns"] - got["epoch_ns"]) / 1e9
            error, count = felt_error(Recording(wearer), Recording(robot), ahead_s, scale)
            print(f"  {name}: {error:.3f} mm RMSE of {count} onsets, {error / best:.2f} times wired; {got['held']} felt of {sent['frames']}, {len(got['pauses'])} pauses")
            # A packet that is lost holds up those behind it, unless there is another connection.
            check(count > 55 and (error <= 1.3 * best or "--once" in more), f"{got}{said}{told}")


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


def forge(lab, member, address, mode="peer", count=200):
    """A program that asks no list: messages that are none under the robot's key, with a member's certificate."""
    script = (
        "import json, sys, time, zenoh\n"
        "member, endpoint, mode, count = sys.argv[1:]\n"
        "config = zenoh.Config()\n"
        "config.insert_json5('mode', json.dumps(mode))\n"
        "config.insert_json5('connect/endpoints', json.dumps([endpoint]))\n"
        "config.insert_json5('scouting/multicast/enabled', 'false')\n"
        "config.insert_json5('transport/link/tls', json.dumps({'root_ca_certificate': member + '/ca.pem', 'enable_mtls': True,\n"
        "    'verify_name_on_connect': False, 'connect_certificate': member + '/cert.pem', 'connect_private_key': member + '/key.pem'}))\n"
        "session = zenoh.open(config)\n"
        "time.sleep(0.5)\n"
        "for _ in range(int(count)):\n"
        "    session.put('palpate/r1/left/index/contacts', bytes([255] * 90)); time.sleep(0.002)\n"
        "time.sleep(0.5)\n"
        "print(len(list(session.info.peers_zid())) + len(list(session.info.routers_zid())))\n"
    )
    program = lab.start("robot", sys.executable, "-c", script, str(member), f"tls/{address}:{PORT}", mode, str(count), **QUIET)
    out, told = program.communicate(timeout=20)
    check(out.strip() == "1", f"the forger is connected: {out}{told}")


def relayed():
    """The two have no way to each other: all goes through a relay, which is killed and started again, and then through two."""
    with Lab(apart=True) as lab:
        check(lab.reaches("robot", HUB) and not lab.reaches("robot", WEARER_APART), "the robot has a way to the wearer")
        check(lab.reaches("wearer", HUB_APART) and not lab.reaches("wearer", ROBOT), "the wearer has a way to the robot")
        # The ends come before the relay, and wait for it.
        robot, wearer = skin(lab, 13, at=through(HUB)), display(lab, 12, at=through(HUB_APART))
        time.sleep(1)
        start_relay = ["relay", "--listen", f"0.0.0.0:{PORT}", "--plain"]
        first = lab.start("hub", PROGRAM, *start_relay, **QUIET)
        time.sleep(3.5)
        listed, _ = result(lab.start("hub", PROGRAM, "list", "--json", *through("127.0.0.1"), **QUIET))
        begun = time.monotonic()
        first.kill()
        first.wait()
        time.sleep(1)
        again = time.monotonic()
        second = lab.start("hub", PROGRAM, *start_relay, **QUIET)
        felt, said = result(wearer)
        sent, told = result(robot)
        second.kill()
        check(len(listed) == 1 and listed[0]["wearers"][0]["feels"] == sent["session"], f"{listed}")
        [(off, back)] = pauses(felt, [(begun, again)])
        median, p99 = added(felt, sent)
        print(f"  {felt['held']} felt of {sent['frames']}; added {median:.2f} ms (median), {p99:.2f} ms (99 %); "
              f"relay killed: off {off} ms after the newest reading, back {back} ms after its start; the robot hears: {sent['stops']}")
        check(felt["held"] > 500 and felt["stimuli"] > 0, f"{felt}{said}{told}")
        check(off is not None and off <= 103 and back is not None and back <= 1000, f"{felt}{said}{told}")
        off_in_time(felt)
        check(sent["stops"] == ["wearer: its time is over"], f"{sent}{told}")
    with tempfile.TemporaryDirectory() as own, Lab(apart=True) as lab:
        own = Path(own)
        keys(own, "--robot", "r1", "--robot", "r2", "--wearer", "w1=r1/*/*", "--relay", "near", "--relay", "far")
        near = lab.start("hub", PROGRAM, "relay", *secure(own, "near", "--listen", f"{HUB}:{PORT}"), **QUIET)
        far = lab.start("hub", PROGRAM, "relay", *secure(own, "far", "--listen", f"{HUB_APART}:{PORT}", "--connect", f"{HUB}:{PORT}"), **QUIET)
        time.sleep(1)
        wearer = display(lab, 11, at=through(HUB_APART, "--keys", str(own / "w1")))
        forged = own / "r2" / "access.toml"
        forged.write_text(forged.read_text().replace('"r2/*/*"', '"r1/*/*"', 1))
        _, refused = result(skin(lab, 2, at=through(HUB, "--keys", str(own / "r2"))))
        check("may not publish" in refused and "access list of" in refused, refused)
        forge(lab, own / "r2", HUB, "client")
        robot = skin(lab, 9, at=through(HUB, "--keys", str(own / "r1")))
        # The finger is its once the wearer feels it: one that comes in the same moment may be first.
        asks = ["list", "--json", *through(HUB_APART, "--keys", str(own / "w1"))]
        for _ in range(5):
            listed, _ = result(lab.start("wearer", PROGRAM, *asks, **QUIET))
            if listed and listed[0]["wearers"] and listed[0]["wearers"][0]["feels"]:
                break
        _, second = result(skin(lab, 2, at=through(HUB, "--keys", str(own / "r1"))))
        felt, said = result(wearer)
        sent, told = result(robot)
        near.kill(), far.kill()
        print(f"  two relays, with certificates: {felt['held']} felt of {sent['frames']}, age {felt['age_ms']}; refused: {refused.strip().splitlines()[-1][:110]}; {second.strip().splitlines()[-1][:110]}")
        check(felt["damaged"] == 0, f"what may not be published was felt by the gate: {felt}")
        check("expected a finger that is not published" in second or "refused by wearer" in second, second)
        check(felt["held"] > 300, f"{felt}{said}{told}{second}")


def security():
    """Certificates and the access list: members, a stranger of the lab, another lab, plain text, an expired certificate."""
    with tempfile.TemporaryDirectory() as own, tempfile.TemporaryDirectory() as other:
        own, other = Path(own), Path(other)
        keys(own, "--robot", "r1", "--robot", "r2", "--wearer", "w1=r1/*/*", "--watcher", "office")
        keys(other, "--robot", "r1", "--wearer", "w1")
        listen = ["--listen", f"{WEARER}:{PORT}"]
        connect = ["--connect", f"{WEARER}:{PORT}"]
        with Lab() as lab:
            wearer = display(lab, 26, at=secure(own, "w1", *listen))
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
            # Two programs that ask no list: one without the right, and one with it, of which every message arrives.
            forge(lab, own / "r2", WEARER)
            forge(lab, own / "r1", WEARER, count=50)
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
            check(felt["frames"]["second"] == 0 and felt["damaged"] == 50, f"{felt}: nothing of a stranger reached the gate")
            check("another lab" in said or "stranger" in said, f"strangers are told: {said}")
        keys(own, "--robot", "r1", "--days", "0")
        with Lab() as lab:
            _, told = result(skin(lab, 2, at=secure(own, "r1", *connect)))
            check("counts from" in told, told)
            print("  expired:", told.strip().splitlines()[-1][:140])


def crowd():
    """1000 publishers of other fingers beside ours, on the same bus, and a recorder that takes all of it."""
    script = (
        "import sys, time, zenoh\n"
        "config = zenoh.Config()\n"
        f"config.insert_json5('connect/endpoints', '[\"tcp/{ROBOT}:{PORT}\"]')\n"
        "config.insert_json5('scouting/multicast/enabled', 'false')\n"
        "session = zenoh.open(config)\n"
        "filling = b'z' + bytes([98]) + bytes(98)  # a field that no message of ours has\n"
        "all = [session.declare_publisher(f'palpate/crowd{n}/left/index/contacts') for n in range(1000)]\n"
        "end = time.monotonic() + float(sys.argv[1])\n"
        "sent = 0\n"
        "while time.monotonic() < end:\n"
        "    for one in all[sent % 10::10]:\n"
        "        one.put(filling)\n"
        "    sent += 1\n"
        "    time.sleep(0.1)\n"
        "print(sent * 100)\n"
    )
    with tempfile.TemporaryDirectory() as folder, Lab() as lab:
        robot, wearer = skin(lab, 11), display(lab, 10)
        recorder = lab.start("wearer", PROGRAM, "record", f"{folder}/all.mcap", "--seconds", "9", "--connect", f"{ROBOT}:{PORT}", "--plain", **QUIET)
        others = lab.start("wearer", sys.executable, "-c", script, "8", **QUIET)
        felt, said = result(wearer)
        sent, _ = result(robot)
        out, told = others.communicate(timeout=20)
        _, noted = result(recorder)
        print(f"  beside {out.strip()} messages of 1000 publishers: {felt['held']} felt of {sent['frames']}, age {felt['age_ms']}; {noted.strip().splitlines()[-1].rsplit('/', 1)[-1]}")
        check(felt["held"] > 500 and not felt["pauses"], f"{felt}{said}{told}")
        topics = {topic for topic, _, _ in messages(f"{folder}/all.mcap") if topic}
        check(len(topics) > 1000 and "/palpate/r1/left/index/contacts" in topics, f"{len(topics)} topics")


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
    with Lab() as lab:
        wearer = display(lab, 14, at=["--listen", f"{WEARER}:{PORT}", "--plain"])
        robot = skin(lab, 14, at=["--connect", f"{WEARER}:{PORT}", "--plain"])
        time.sleep(3)
        flood = lab.start("robot", sys.executable, "-c", script, **QUIET)
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
        check(felt["damaged"] > 0, f"{felt}")
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


def cost():
    """What a message costs the relay, the robot's and the wearer's machine: processor time while all runs, over 5 s."""
    once = ["--once"]
    rows = (("contacts", "sphere-along", 1, 1, 100, once), ("contacts", "sphere-along", 1, 6, 100, once), ("contacts", "sphere-along", 6, 1, 100, once),
            ("contacts", "allegro-grasp", 1, 1, 100, once), ("scans", "sphere-along", 1, 1, 100, once), ("scans", "allegro-grasp", 1, 1, 1500, once),
            ("contacts", "sphere-along", 1, 1, 100, []), ("scans", "allegro-grasp", 1, 1, 1500, []))
    relayed_us = {}
    for send, scene, robots, wearers, rate, more in rows:
        with Lab(apart=True) as lab:
            relay = lab.start("hub", PROGRAM, "relay", "--listen", f"0.0.0.0:{PORT}", "--plain", **QUIET)
            time.sleep(0.5)
            name = [f"r{n}/left/index" for n in range(robots)]
            skins = [lab.start("robot", PROGRAM, "skin", scene, "--finger", finger, "--send", send, "--json", "--seconds", "9", *through(HUB), *more, **QUIET) for finger in name]
            time.sleep(0.5)
            displays = [lab.start("wearer", PROGRAM, "display", scene, "--finger", finger, "--json", "--seconds", "8", "--wearer", f"w{n}", *through(HUB_APART), *more, **QUIET)
                        for finger in name for n in range(wearers)]
            time.sleep(2)
            all_of = [relay, skins[0], displays[0]]
            before, begun = [processor_s(p) for p in all_of], time.monotonic()
            time.sleep(5)
            spent, seconds = [processor_s(p) - b for p, b in zip(all_of, before)], time.monotonic() - begun
            sent = [result(one)[0] for one in skins]
            worn = [result(one)[0] for one in displays]
            into, out = robots * rate, robots * wearers * rate
            per = [1e6 * s / seconds / n for s, n in zip(spent, (into + out, rate, rate))]
            held = min(w["held"] for w in worn)
            print(f"  {'once' if more else 'twice'}: {send} of {scene}, {robots} robots, {wearers} wearers each: {sent[0]['bytes'] / sent[0]['frames']:.0f} bytes a message, {sent[0]['bytes'] / sent[0]['frames'] * rate / 1000:.1f} kB/s a robot; "
                  f"relay {spent[0] / seconds:.3f} of a core for {into} messages/s in and {out} out, {per[0]:.1f} us each; robot {per[1]:.0f} us, wearer {per[2]:.0f} us a message; at least {held} felt")
            relayed_us[robots, wearers, send, scene, *more] = 1e6 * spent[0] / seconds
            check(held > 4 * 100, f"{held}")
    few, many_out = relayed_us[1, 1, "contacts", "sphere-along", *once], relayed_us[1, 6, "contacts", "sphere-along", *once]
    many_in = relayed_us[6, 1, "contacts", "sphere-along", *once]
    out = (many_out - few) / 500
    print(f"  a further wearer costs the relay {out:.1f} us a frame, a further robot with its wearer {(many_in - few) / 500:.1f} us a frame")


SCENARIOS = {f.__name__: f for f in (quiet, clocks, cuts, often, weather, felt, router, relayed, security, crowd, gigabyte, many, cost)}

if __name__ == "__main__":
    signal.alarm(900)
    if shutil.which("ip") is None:
        sys.exit("link: expected iproute2")
    for name in sys.argv[2:] or SCENARIOS:
        print(f"link: {name}: {SCENARIOS[name].__doc__.splitlines()[0]}", flush=True)
        SCENARIOS[name]()
