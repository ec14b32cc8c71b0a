"""python-can and cantools on the served interface: readings in the units and ranges of the DBC."""
import sys

import can
import cantools

interface, dbc = sys.argv[1:]
messages = cantools.database.load_file(dbc)
names = set()
with can.Bus(channel=interface, interface="socketcan") as bus:
    for _ in range(160):
        frame = bus.recv(timeout=30)
        assert frame is not None, "no frame within 30 s"
        reading = messages.decode_message(frame.arbitration_id, frame.data)
        data = frame.data
        for axis, at in (("X", 1), ("Y", 3), ("Z", 5)):
            assert reading[axis] == data[at] << 8 | data[at + 1], (frame, reading)
        assert set(reading) == {"X", "Y", "Z"}, reading
        names.add(messages.get_message_by_frame_id(frame.arbitration_id).name)
assert names == {f"Board4_Taxel{n}" for n in range(16)}, names
print("ok")
