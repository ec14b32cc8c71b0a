"""Prints the contacts of every finger: `palpate-link schema --binary > link.desc; python contacts.py link.desc 127.0.0.1:7450`."""

import sys

import zenoh
from google.protobuf import descriptor_pb2, message_factory

files = descriptor_pb2.FileDescriptorSet.FromString(open(sys.argv[1], "rb").read())
Touched = message_factory.GetMessages(files.file)["palpate.Touched"]
config = zenoh.Config.from_json5(f'{{mode: "client", connect: {{endpoints: ["tcp/{sys.argv[2]}"]}}, scouting: {{multicast: {{enabled: false}}}}}}')
with zenoh.open(config) as session:
    subscriber = session.declare_subscriber("palpate/*/*/*/contacts")
    for sample in subscriber:
        for contact in Touched.FromString(bytes(sample.payload)).contacts:
            print(sample.key_expr, contact.contact, f"{contact.x_mm:.2f} {contact.y_mm:.2f} mm", flush=True)
