"""Opens the records of one run with other people's readers and holds them against one another.

    read.py FOLDER DBC

FOLDER holds run.mcap, run.vcd, run.log, run.csv with run.schema.json, run.jsonl, foxglove.json and plotjuggler.xml; run.wav is
of another run.
"""

import io
import json
import math
import struct
import sys
import wave
from collections import Counter
from pathlib import Path
from xml.etree import ElementTree

import can
import cantools
import pandas
import polars
from foxglove_schemas_protobuf.FrameTransform_pb2 import FrameTransform
from foxglove_schemas_protobuf.Log_pb2 import Log
from foxglove_schemas_protobuf.PointCloud_pb2 import PointCloud
from foxglove_schemas_protobuf.SceneUpdate_pb2 import SceneUpdate
from google.protobuf.descriptor_pb2 import FileDescriptorSet
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
                ticks.append((message.log_time // 1000, value.board, value.channel, value.on, value.off, value.requested, value.pulses, value.period))
            elif kind.name == "foxglove.Log":
                log = Log.FromString(message.data)
                assert log.message and log.level == Log.Level.INFO, log
        same("messages", sum(topics.values()), reader.get_summary().statistics.message_count)
    same("contacts in MCAP", topics["/contacts"], len(contacts))
    columns = ["frame", "x_mm", "y_mm", "intensity"]
    assert places == list(contacts[columns].itertuples(index=False, name=None))
    same("CAN frames in MCAP", topics["/can"], frames)
    keys = ("t_us", "board", "channel", "on", "off", "requested", "pulses", "period")
    assert sorted(ticks) == sorted(tuple(e[k] for k in keys) for e in entries)
    same("schedule entries in MCAP", len(ticks), len(entries))
    return max(temperatures)


PUBLISHED = {m.DESCRIPTOR.full_name: m for m in (Log, PointCloud, SceneUpdate, FrameTransform)}


def as_published(schema):
    """Every message and field of a schema has the number, name, type and label that Foxglove publishes."""
    ours = {}
    for file in FileDescriptorSet.FromString(schema.data).file:
        for message in file.message_type:
            fields = [(f.number, f.name, f.type, f.label == f.LABEL_REPEATED, f.type_name.lstrip(".")) for f in message.field]
            enums = {e.name: [(v.number, v.name) for v in e.value] for e in message.enum_type}
            ours[f"{file.package}.{message.name}"] = (fields, enums)
    pending, seen = [PUBLISHED[schema.name].DESCRIPTOR], set()
    while pending:
        theirs = pending.pop()
        if theirs.full_name in seen:
            continue
        seen.add(theirs.full_name)
        kind = lambda f: (f.message_type or f.enum_type).full_name if f.message_type or f.enum_type else ""
        fields = [(f.number, f.name, f.type, f.is_repeated, kind(f)) for f in theirs.fields]
        enums = {e.name: [(v.number, v.name) for v in e.values] for e in theirs.enum_types}
        assert ours[theirs.full_name] == (fields, enums), (theirs.full_name, ours[theirs.full_name], fields)
        pending += [f.message_type for f in theirs.fields if f.message_type]
    return len(seen)


def pictures(readings):
    """What Foxglove draws: its own classes read it, points have the taxels' values, and those are what the bus carried."""
    relative, clouds, drawn, frames, schemas = {}, 0, Counter(), set(), {}
    with (folder / "run.mcap").open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        for kind, channel, message, value in reader.iter_decoded_messages():
            schemas[kind.name] = kind
            if channel.topic == "/taxels/0":
                assert len(value.x) == len(value.y) == len(value.z) == len(value.relative) == 16, value
                if all(value.z):
                    assert set(zip(value.x, value.y, value.z)) <= readings, value
                relative[message.log_time] = list(value.relative)
            elif kind.name == "foxglove.PointCloud":
                cloud = PointCloud.FromString(message.data)
                names = [f.name for f in cloud.fields]
                assert cloud.frame_id in frames and names == ["x", "y", "z", "counts"], cloud
                points = list(struct.iter_unpack("<4f", cloud.data))
                assert cloud.point_stride == 16 and len(points) == 16
                assert [p[3] for p in points] == relative[message.log_time]
                clouds += 1
            elif kind.name == "foxglove.FrameTransform":
                frames.add(FrameTransform.FromString(message.data).child_frame_id)
            elif kind.name == "foxglove.SceneUpdate":
                for entity in SceneUpdate.FromString(message.data).entities:
                    assert entity.frame_id in frames, entity
                    drawn[entity.id] += len(entity.spheres) + len(entity.cubes)
    same("types as Foxglove publishes them", sum(as_published(schemas[n]) for n in PUBLISHED if n in schemas), 31)
    assert len(relative) > 500 and max(map(max, relative.values())) > 50, len(relative)
    assert 200 <= clouds <= 251 and drawn["wires"] > 1000 and drawn["contacts 0"] > 100 and drawn["felt"] > 100, (clouds, drawn)
    print(f"  frames of taxels: {len(relative)}, each among the bus's readings; point clouds: {clouds}; shapes: {dict(drawn)}")


def views():
    """What the ready views show is in the recording, by the names that each program gives it."""
    dots, slashes, topics = set(), set(), set()
    with (folder / "run.mcap").open("rb") as file:
        for kind, channel, _, value in make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages():
            topics.add(channel.topic)
            for field in value.DESCRIPTOR.fields:
                many = range(len(getattr(value, field.name))) if field.is_repeated else [None]
                for n in many:
                    end = field.name if n is None else f"{field.name}[{n}]"
                    dots.add(f"{channel.topic}.{end}")
                    slashes.add(f"{channel.topic}/{end}")
    view = json.loads((folder / "foxglove.json").read_text())
    panels = view["configById"]
    shown, pending = set(), [view["layout"]]
    while pending:
        node = pending.pop()
        if isinstance(node, str):
            shown.add(node)
        else:
            assert node["direction"] in ("row", "column") and 0 < node["splitPercentage"] < 100
            pending += [node["first"], node["second"]]
    assert shown == set(panels), shown ^ set(panels)
    assert {p.split("!")[0] for p in panels} == {"3D", "Plot", "RosOut"}
    paths = [p["value"] for name, panel in panels.items() if name.startswith("Plot!") for p in panel["paths"]]
    missing = [p for p in paths if p not in dots] + [t for t in panels["3D!palpate"]["topics"] if t not in topics]
    assert not missing, missing
    same("panels of the view for Foxglove", len(panels), 6)
    root = ElementTree.parse(folder / "plotjuggler.xml").getroot()
    assert root.tag == "root" and root.find("tabbed_widget").get("parent") == "main_window"
    curves = [c.get("name") for c in root.findall("./tabbed_widget/Tab/Container/DockSplitter/DockArea/plot[@mode='TimeSeries']/curve")]
    missing = [c for c in curves if c not in slashes]
    assert not missing and len(curves) == len(root.findall(".//curve")), missing
    for splitter in root.iter("DockSplitter"):
        assert int(splitter.get("count")) == len(splitter) == len(splitter.get("sizes").split(";"))
    same("curves of the views (PlotJuggler, Foxglove)", (len(curves), len(paths)), (45, 36))


def torn():
    """A recording that was cut: their reader gets what is there and then says where it ends."""
    whole = (folder / "run.mcap").read_bytes()
    count = 0
    try:
        for _ in NonSeekingReader(io.BytesIO(whole[: len(whole) // 2])).iter_messages(log_time_order=False):
            count += 1
    except (McapError, EOFError, struct.error):
        pass  # the last where the cut lies within a record of an index
    assert count > 1000, count
    print(f"  messages of the first half: {count}")


def log():
    """The candump log, read by python-can and decoded by cantools."""
    database = cantools.database.load_file(dbc)
    frames, readings, seen = 0, 0, set()
    for message in can.CanutilsLogReader(folder / "run.log"):
        frames += 1
        assert not message.is_extended_id and message.dlc <= 8
        values = database.decode_message(message.arbitration_id, message.data)
        seen.add((values["X"], values["Y"], values["Z"]))
        readings += all(0 <= values[axis] <= 65535 for axis in ("X", "Y", "Z"))
    same("readings decoded by cantools", readings, frames)
    return frames, seen


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


def sound():
    """The WAV file of voice coils: eight channels, each with bursts, none over what the bench gives."""
    with wave.open(str(folder / "run.wav")) as file:
        same("sound", (file.getnchannels(), file.getsampwidth(), file.getframerate()), (8, 2, 48000))
        data = file.readframes(file.getnframes())
    samples = struct.unpack(f"<{len(data) // 2}h", data)
    # 0.3 V RMS of 2 V at full scale.
    most = int(0.3 * math.sqrt(2) / 2 * 32767)
    peaks = [max(map(abs, samples[channel::8])) for channel in range(8)]
    assert all(0 < peak <= most for peak in peaks), peaks
    print(f"  peaks of the channels: {peaks} of {most}")


contacts = table()
frames, readings = log()
dump(recording(contacts, frames))
pictures(readings)
views()
torn()
sound()
print("readers: every record opens")
