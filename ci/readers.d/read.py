"""Opens the records of one run with other people's readers and holds them against one another.

    read.py FOLDER DBC

FOLDER holds run.mcap, run.vcd, run.log, run.csv with run.schema.json, and run.jsonl.
"""

import io
import json
import math
import sys
from collections import Counter
from pathlib import Path

import can
import cantools
import pandas
import polars
from foxglove_schemas_protobuf.Log_pb2 import Log
from mcap.exceptions import McapError
from mcap.reader import NonSeekingReader, make_reader
from mcap_protobuf.decoder import DecoderFactory
from vcdvcd import VCDVCD

folder, dbc = Path(sys.argv[1]), sys.argv[2]
schema = json.loads((folder / "run.schema.json").read_text())
header, *schedule = [json.loads(line) for line in (folder / "run.jsonl").read_text().splitlines()]
entries = [record for record in schedule if "channel" in record]


def same(what, a, b):
    if a != b:
        sys.exit(f"{what}: {a!r} is not {b!r}")
    print(f"  {what}: {a}")


def table():
    """The contacts as pandas and as polars read them, typed by the schema beside them."""
    types = {field["name"]: field["type"] for field in schema["fields"]}
    assert all(field["unit"] and field["description"] for field in schema["fields"])
    numpy_types = {"integer": "int64", "number": "float64"}
    polars_types = {"integer": polars.Int64, "number": polars.Float64}
    a = pandas.read_csv(folder / "run.csv", dtype={n: numpy_types[t] for n, t in types.items()})
    b = polars.read_csv(folder / "run.csv", schema={n: polars_types[t] for n, t in types.items()})
    same("columns (pandas, polars)", list(a.columns), b.columns)
    same("contacts (pandas, polars)", len(a), b.height)
    assert not a.isna().any().any()
    for name in types:
        assert a[name].tolist() == b[name].to_list(), name
    return a


def recording(contacts, frames):
    """The MCAP file: counts and values are those of the other records."""
    path = folder / "run.mcap"
    topics, places, temperatures, ticks = Counter(), [], [], []
    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        attached = {a.name for a in reader.iter_attachments()}
        assert {"scene.toml", "bench.toml", "limits.toml", "sensor.toml"} <= attached, attached
        facts = next(m.metadata for m in reader.iter_metadata() if m.name == "palpate")
        for key in ("scene_digest", "limits_digest", "source"):
            same(key, facts[key], header[key])
        last = 0
        for kind, channel, message, value in reader.iter_decoded_messages():
            topics[channel.topic] += 1
            assert message.log_time >= last
            last = message.log_time
            if channel.topic == "/contacts":
                places.append((value.frame, value.x_mm, value.y_mm, value.intensity))
            elif channel.topic.endswith("/temperature"):
                temperatures.append(value.celsius)
            elif channel.topic.endswith("/schedule"):
                ticks.append((message.log_time // 1000, value.board, value.channel, value.on, value.off, value.requested))
            elif kind.name == "foxglove.Log":
                log = Log.FromString(message.data)
                assert log.message and log.level == Log.Level.INFO, log
        same("messages", sum(topics.values()), reader.get_summary().statistics.message_count)
    same("contacts in MCAP", topics["/contacts"], len(contacts))
    columns = ["frame", "x_mm", "y_mm", "intensity"]
    assert places == list(contacts[columns].itertuples(index=False, name=None))
    same("CAN frames in MCAP", topics["/can"], frames)
    keys = ("t_us", "board", "channel", "on", "off", "requested")
    assert sorted(ticks) == sorted(tuple(e[k] for k in keys) for e in entries)
    same("schedule entries in MCAP", len(ticks), len(entries))
    return max(temperatures)


def torn():
    """A recording that was cut: their reader gets what is there and then says where it ends."""
    whole = (folder / "run.mcap").read_bytes()
    count = 0
    try:
        for _ in NonSeekingReader(io.BytesIO(whole[: len(whole) // 2])).iter_messages(log_time_order=False):
            count += 1
    except (McapError, EOFError):
        pass
    assert count > 1000, count
    print(f"  messages of the first half: {count}")


def log():
    """The candump log, read by python-can and decoded by cantools."""
    database = cantools.database.load_file(dbc)
    frames, readings = 0, 0
    for message in can.CanutilsLogReader(folder / "run.log"):
        frames += 1
        assert not message.is_extended_id and message.dlc <= 8
        values = database.decode_message(message.arbitration_id, message.data)
        readings += all(0 <= values[axis] <= 65535 for axis in ("X", "Y", "Z"))
    same("readings decoded by cantools", readings, frames)
    return frames


def dump(hottest):
    """The VCD: pulses are as long as the schedule says, the hottest wire is as hot as in the MCAP file."""
    vcd = VCDVCD(str(folder / "run.vcd"), store_tvs=True)
    same("timescale", str(vcd.timescale["magnitude"]) + vcd.timescale["unit"], "1ns")
    tick = header["period_ns"] / 4096
    asked = {e["off"] - e["on"] for e in entries}
    pulses = 0
    warmest = -math.inf
    for name in vcd.signals:
        changes = vcd[name].tv
        if "pin_" in name:
            for (rise, high), (fall, low) in zip(changes, changes[1:]):
                if high == "1" and low == "0":
                    pulses += 1
                    width = (fall - rise) / tick
                    assert round(width) in asked and abs(width - round(width)) < 1e-3, (name, rise, width)
        elif name.endswith("wire_celsius"):
            warmest = max([warmest] + [float(value) for _, value in changes])
    assert pulses > 100, pulses
    print(f"  pulses in VCD: {pulses}, each as wide as scheduled")
    same("hottest wire in VCD and MCAP, C", warmest, hottest)


contacts = table()
dump(recording(contacts, log()))
torn()
print("readers: every record opens")
