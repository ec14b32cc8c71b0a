"""The same touch written by other people's programs in many ways, and read by `hil`, which finds the same contacts in all.

    cross.py HIL COUNT

COUNT files of each format with what their writers leave open drawn by chance: pandas (separators, decimal commas, quotes, times,
the order of columns), NumPy (types, orders, savetxt), mcap (JSON, several topics, packed chunks), python-can (candump logs), pyvcd
(a capture of pins, whose verdict against the schedule is that of our own dump), pylibfst (the same by GTKWave's library, which
simulators use).
"""

import json
import random
import subprocess
import sys
import tempfile
from pathlib import Path

import can
import numpy
import pandas
import pylibfst
from mcap.writer import CompressionType, Writer
from vcd import VCDWriter
from vcdvcd import VCDVCD

HIL, COUNT = sys.argv[1], int(sys.argv[2])
ROWS, RATE = 60, 100
NAMES = [f"txl{t + 1}_{axis}" for t in range(16) for axis in "xyz"]
START_NS = 1_772_366_400_000_000_000


def touch():
    """Raw counts: a pad at rest, then a finger that wanders over it."""
    noise = numpy.random.default_rng(5)
    counts = 32_000 + noise.integers(-3, 4, (ROWS, 48))
    for row in range(30, ROWS):
        for taxel in range(16):
            x, y = taxel % 4 - (row - 30) / 10, taxel // 4 - 1.5
            counts[row, 3 * taxel + 2] += int(900 * numpy.exp(-(x * x + y * y)))
    return counts.astype(numpy.uint16)


def contacts(path, *options):
    """Contacts without their times."""
    command = [HIL, "contacts", str(path), "--layout", "uskin-4x4", "--quiet", *options]
    said = subprocess.run(command, capture_output=True, text=True)
    if said.returncode:
        sys.exit(f"{' '.join(command)}: {said.stderr}")
    return [[f for n, f in enumerate(line.split(",")) if n != 1] for line in said.stdout.splitlines()]


def by_pandas(counts, folder, draw):
    separator = draw.choice([",", ";", "\t"])
    decimal = draw.choice([".", ","]) if separator != "," else "."
    table = pandas.DataFrame(counts, columns=NAMES)
    if draw.random() < 0.5:
        table = table.astype(float)
    name, times = draw.choice([
        ("time_ns", [START_NS + n * 10_000_000 for n in range(ROWS)]),
        ("Time (ms)", [n * 10 for n in range(ROWS)]),
        ("t", [n / RATE for n in range(ROWS)]),
        ("timestamp", pandas.date_range("2026-03-01", periods=ROWS, freq="10ms")),
    ])
    order = list(NAMES)
    if draw.random() < 0.5:
        draw.shuffle(order)
    table = table[order]
    table.insert(draw.choice([0, len(NAMES)]), name, times)
    path = folder / "pandas.csv"
    table.to_csv(path, sep=separator, decimal=decimal, index=False, quoting=draw.choice([0, 1, 2]),
                 lineterminator=draw.choice(["\n", "\r\n"]), encoding=draw.choice(["utf-8", "utf-8-sig"]))
    return contacts(path)


def by_numpy(counts, folder, draw):
    counts = counts.astype(draw.choice(["u2", ">u2", "i4", "u8", "f4", ">f4", "f8"]))
    kind = draw.choice(["npy", "npz", "txt", "frames"])
    path = folder / f"numpy.{kind}"
    if kind == "npy":
        shaped = counts.reshape(draw.choice([(ROWS, 48), (ROWS, 16, 3)]))
        numpy.save(path, numpy.asfortranarray(shaped) if draw.random() < 0.5 else shaped)
    elif kind == "npz":
        save = draw.choice([numpy.savez, numpy.savez_compressed])
        save(path, raw=counts)
    elif kind == "txt":
        numpy.savetxt(path, counts, fmt=draw.choice(["%.18e", "%d", "%.2f"]), delimiter=draw.choice([" ", ",", "\t"]))
    else:
        with path.open("w") as file:
            for frame in counts.reshape(ROWS, 16, 3):
                numpy.savetxt(file, frame, fmt=draw.choice(["%d", "%.3f"]))
                file.write("# New slice\n")
    return contacts(path, "--rate", str(RATE))


def by_mcap(counts, folder, draw):
    path = folder / "skin.mcap"
    with path.open("wb") as file:
        writer = Writer(file, compression=draw.choice(list(CompressionType)), use_chunking=draw.random() < 0.7)
        writer.start()
        schema = writer.register_schema(name="skin", encoding="jsonschema", data=b"{}")
        topics = {name: writer.register_channel(topic=name, message_encoding="json", schema_id=schema) for name in ("/wide", "/skin")}
        for row in range(ROWS):
            ns = START_NS + row * 10_000_000
            for topic, values in (("/wide", [0] * 99), ("/skin", counts[row].tolist())):
                data = json.dumps({"data": values}).encode()
                writer.add_message(topics[topic], log_time=ns, publish_time=ns, data=data)
        writer.finish()
    return contacts(path, "--topic", "/skin")


def replayed(path):
    said = subprocess.run([HIL, "run", "--layout", "uskin-4x4", "--replay", str(path), "--json"], capture_output=True, text=True)
    if said.returncode not in (0, 1):
        sys.exit(f"{path}: {said.stderr}")
    summary = json.loads(said.stdout)
    return summary["contacts"], summary["stimuli"]


def by_python_can(log, folder, draw):
    """A log of ours read and written again by python-can, which writes frames with other letters and blanks."""
    path = folder / draw.choice(["again.log", "again.txt"])
    messages = list(can.CanutilsLogReader(log))
    with can.CanutilsLogWriter(path) as writer:
        for message in messages:
            writer.on_message_received(message)
    return replayed(path)


def verdict(folder, capture):
    """What `hil diff` says of a capture beside the schedule of its run, without the capture's name."""
    said = subprocess.run([HIL, "diff", str(folder / "run.jsonl"), str(capture)], capture_output=True, text=True)
    if said.returncode not in (0, 1):
        sys.exit(f"{capture}: {said.stderr}")
    return said.stdout.replace(str(capture), "CAPTURE")


def by_pyvcd(own, folder, draw):
    """The pins of our dump, as vcdvcd reads them, written again: other types, scopes, identifiers, order and time scale."""
    path = folder / "again.vcd"
    kind, scale, first = draw.choice(["wire", "reg", "logic", "bit"]), draw.choice(["1 ns", "100 ps", "10 ps"]), draw.choice([0, 1])
    steps = {"1 ns": 1, "100 ps": 10, "10 ps": 100}[scale]
    names = [name for name in own.signals if own[name].size == "1"]
    draw.shuffle(names)
    with path.open("w") as file, VCDWriter(file, timescale=scale, date="today", comment=draw.choice(["", "by pyvcd"])) as writer:
        changes, pins = [], {}
        for name in names:
            scope, _, pin = name.rpartition(".")
            pins[name] = writer.register_var(scope, pin, kind, size=1, init=own[name].tv[0][1])
            changes += [(time, name, value) for time, value in own[name].tv[first:]]
        for time, name, value in sorted(changes, key=lambda change: change[0]):
            writer.change(pins[name], steps * time, value)
        writer.close(steps * own.endtime)
    return verdict(folder, path)


def by_pylibfst(own, folder, draw):
    """The pins of our dump by GTKWave's library: other packings, sections, scopes, order and time scale."""
    path, library = folder / "again.fst", pylibfst.lib
    exponent, steps = draw.choice([(-9, 1), (-10, 10), (-11, 100)])
    names = [name for name in own.signals if own[name].size == "1"]
    draw.shuffle(names)
    writer = library.fstWriterCreate(str(path).encode(), 1)
    library.fstWriterSetPackType(writer, draw.choice([0, 1, 2]))
    library.fstWriterSetTimescale(writer, exponent)
    changes, pins = [], {}
    for name in names:
        *scopes, pin = name.split(".")
        for scope in scopes:
            library.fstWriterSetScope(writer, 0, scope.encode(), b"")
        pins[name] = library.fstWriterCreateVar(writer, 16, 0, 1, pin.encode(), 0)
        for _ in scopes:
            library.fstWriterSetUpscope(writer)
        changes += [(time, name, value) for time, value in own[name].tv]
    now = None
    for time, name, value in sorted(changes, key=lambda change: change[0]):
        if time != now:
            if now is not None and draw.random() < 0.01:
                library.fstWriterFlushContext(writer)
            now = time
            library.fstWriterEmitTimeChange(writer, steps * time)
        library.fstWriterEmitValueChange(writer, pins[name], value.encode())
    library.fstWriterEmitTimeChange(writer, steps * own.endtime)
    library.fstWriterClose(writer)
    return verdict(folder, path)


def main():
    counts = touch()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        pandas.DataFrame(counts, columns=NAMES).to_csv(folder / "own.csv", index=False)
        expected = contacts(folder / "own.csv", "--rate", str(RATE))
        assert len(expected) > 20, "a finger wanders over the pad"
        for writer in (by_pandas, by_numpy, by_mcap):
            for seed in range(COUNT):
                if writer(counts, folder, random.Random(seed)) != expected:
                    sys.exit(f"{writer.__name__}, seed {seed}: other contacts than in the plain table")
            print(f"  {writer.__name__}: {COUNT} files, the same contacts in all")
        log = folder / "run.log"
        subprocess.run([HIL, "run", "sphere-along", "--quiet", "--record", str(log)], check=True)
        expected = replayed(log)
        for seed in range(max(1, COUNT // 10)):
            if by_python_can(log, folder, random.Random(seed)) != expected:
                sys.exit(f"python-can, seed {seed}: another run than of the log itself")
        print(f"  python-can: {max(1, COUNT // 10)} logs, the same run of all")
        subprocess.run([HIL, "run", "sphere-along", "--quiet", "--record", str(folder / "run.jsonl"), "--record", str(folder / "run.vcd")], check=True)
        own, expected = VCDVCD(str(folder / "run.vcd"), store_tvs=True), verdict(folder, folder / "run.vcd")
        for writer in (by_pyvcd, by_pylibfst):
            for seed in range(max(1, COUNT // 10)):
                if (found := writer(own, folder, random.Random(seed))) != expected:
                    sys.exit(f"{writer.__name__}, seed {seed}: another verdict than of our dump:\n{found}\n{expected}")
            print(f"  {writer.__name__}: {max(1, COUNT // 10)} captures, the verdict of our dump for all")


main()
