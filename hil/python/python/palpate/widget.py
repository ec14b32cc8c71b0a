"""The page over a loop, in a notebook. anywidget has to be installed: ``palpate[notebook]``.

>>> import palpate
>>> import palpate.widget
>>> loop = palpate.Loop("uskin-4x4", skin="emulated")
>>> page = palpate.widget.Page(loop)
"""

from __future__ import annotations

import base64
import json
from collections.abc import Callable
from typing import Any

import anywidget
import traitlets

from . import _palpate
from ._errors import Error, InputError
from ._loop import Loop, Step

__all__ = ["Page"]

# A message asks for so much time at most, microseconds: what a page does that keeps to the wall clock, and the reference.
_MOST_US = 60_000_000

# The page is a document of its own in a frame without rights: it reaches neither the notebook nor any server.
_ESM = """
export default {
  render({ model, el }) {
    const frame = document.createElement("iframe");
    frame.title = "Palpate: the robot's skin, and what is felt";
    frame.setAttribute("sandbox", "allow-scripts allow-popups");
    frame.style.cssText = "display:block;width:100%;height:900px;border:0";
    const hear = ({ source, data }) => {
      if (source !== frame.contentWindow) return;
      if (data.height) frame.style.height = `${data.height}px`;
      if (data.say) model.send(data.say);
    };
    const tell = message => frame.contentWindow?.postMessage(message, "*");
    addEventListener("message", hear);
    model.on("msg:custom", tell);
    frame.srcdoc = model.get("_text");
    el.append(frame);
    return () => { removeEventListener("message", hear); model.off("msg:custom", tell); frame.remove(); };
  },
};
"""


def _text() -> str:
    """The page with all that it loads."""
    page, scripts = _palpate.notebook()

    def inside(script: str) -> str:
        return "data:text/javascript;base64," + base64.b64encode(script.encode()).decode()

    modules = {f"palpate/{name}": inside(script) for name, script in scripts}
    return page.replace('{ "imports": { "palpate/": "./" } }', json.dumps({"imports": modules}), 1)


class Page(anywidget.AnyWidget):
    """The page of the playground over a loop: touches in it go to the loop, and pictures come back.

    A loop with ``skin="emulated"`` is touched in the page, and its time goes on as the wall clock's does while the kernel has
    nothing else to do. A loop whose readings are pushed is only shown: call :meth:`show` after :meth:`Loop.push`.

    Args:
        loop: The loop. It may be stepped from the notebook as well.
        each: Is called with every :class:`Step` that the page makes.
    """

    _esm = _ESM
    _text = traitlets.Unicode().tag(sync=True)

    def __init__(self, loop: Loop, each: Callable[[Step], object] | None = None) -> None:
        self._loop, self._each = loop, each
        self._touched = loop.is_emulated
        self._fingers: dict[int, tuple[int, list[float]]] = {}
        # Of several views of one page the newest makes time go on; all are shown it.
        self._newest: int | None = None
        self._head = json.loads(loop._inner.show())
        super().__init__(_text=_text())
        self.on_msg(self._hear)

    def show(self) -> None:
        """Shows the events since the last picture."""
        self.send({"picture": self._loop._inner.picture()})

    def _hear(self, _widget: object, said: dict[str, Any], _buffers: object) -> None:
        try:
            if "hello" in said:
                self._newest = int(said["hello"])
                self.send({"head": self._head, "touched": self._touched, "now_us": self._loop.time_us})
                if not self._touched:
                    self.show()
            elif said.get("from") == self._newest and self._touched:
                self._step(said)
        except Error as error:
            self.send({"failed": str(error)})
        except (KeyError, TypeError, ValueError) as error:
            self.send({"failed": f"a message of the page: {type(error).__name__}: {error}"})

    def _step(self, said: dict[str, Any]) -> None:
        us = int(said["us"])
        if not 0 <= us <= _MOST_US:
            raise InputError.of("us", f"0 to {_MOST_US}", repr(us))
        self._touch(said["fingers"])
        step = self._loop.advance(self._loop.time_us + us)
        if self._each is not None:
            self._each(step)
        self.send({"picture": self._loop._inner.picture(), "to": self._newest})

    def _touch(self, fingers: list[list[int]]) -> None:
        """Takes what changed: number, module, x, y (um), force (mN) and diameter (um) of a finger."""
        changed = set()
        for number, module, *rest in fingers:
            before = self._fingers.pop(number, None)
            if before is not None:
                changed.add(before[0])
            x, y, force, size = (value / 1000 for value in rest)
            if force > 0:
                self._fingers[number] = (module, [x, y, force, size])
            changed.add(module)
        for module in changed:
            here = [press for on, press in self._fingers.values() if on == module]
            places, forces, sizes = ([p[0:2] for p in here], [p[2] for p in here], [p[3] for p in here])
            self._loop.touch(places, forces, diameter_mm=sizes, module=module)
