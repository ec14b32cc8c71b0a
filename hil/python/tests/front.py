"""A page over a loop, for a front end at the other end of a pipe: a line of JSON per message."""

from __future__ import annotations

import json
import sys

import palpate
from palpate.widget import Page


def tell(message: object, buffers: object = None) -> None:
    print(json.dumps(message), flush=True)


page = Page(palpate.Loop("uskin-4x4", skin="emulated"))
page.send = tell
tell({"esm": str(page._esm), "text": page._text})
for line in sys.stdin:
    page._handle_custom_msg(json.loads(line), [])
