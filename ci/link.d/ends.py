"""The two ends as programs in their namespaces, and what is read from what they print."""

import json
import subprocess
import sys
from pathlib import Path

from lab import ROBOT

PROGRAM, HIL = (str(Path(sys.argv[1]).resolve() / name) for name in ("palpate-link", "hil"))
FINGER = ["--finger", "r1/left/index"]
PORT = 7450
QUIET = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE}


def result(program, seconds=30):
    out, said = program.communicate(timeout=seconds)
    return (json.loads(out) if out.strip().startswith(("{", "[")) else None), said


def skin(lab, seconds, *more, at=None, scene="sphere-along", under=()):
    at = at or ["--listen", f"{ROBOT}:{PORT}", "--plain"]
    words = ["skin", scene, *FINGER, "--json", "--seconds", str(seconds), *at, *more]
    return lab.start("robot", *under, PROGRAM, *words, **QUIET)


def display(lab, seconds, *more, at=None, scene="sphere-along", under=()):
    at = at or ["--connect", f"{ROBOT}:{PORT}", "--plain"]
    words = ["display", scene, *FINGER, "--json", "--seconds", str(seconds), *at, *more]
    return lab.start("wearer", *under, PROGRAM, *words, **QUIET)


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


def added(felt, sent, ahead_s=0):
    """What the network added to a frame, ms: median and 99 %. Both clocks are this machine's, so their offset is known; that
    of the wearer may be set ahead."""
    offset_us = ahead_s * 1e6 + (sent["epoch_ns"] - felt["epoch_ns"]) / 1e3
    more = (felt["offset_us"][1] - offset_us) / 1e3
    check(felt["offset_us"][0] - 1 <= offset_us <= felt["offset_us"][1] + 1, "the true offset is within its bounds")
    return felt["flight_ms"]["median"] + more, felt["flight_ms"]["p99"] + more


def through(address, *more):
    return ["--relay", f"{address}:{PORT}", *(more or ["--plain"])]


def keys(folder, *words):
    subprocess.run([PROGRAM, "keys", str(folder), *words], check=True, stdout=subprocess.DEVNULL)


def secure(folder, name, *words):
    return [*words, "--keys", str(folder / name)]


def processor_s(program):
    """Processor time of all its threads so far."""
    threads = Path(f"/proc/{program.pid}/task").glob("*/schedstat")
    return sum(int(thread.read_text().split()[0]) for thread in threads) / 1e9
