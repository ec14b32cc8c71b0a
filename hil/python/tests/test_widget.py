"""The page over a loop, as a front end speaks with it."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest

import palpate

pytest.importorskip("anywidget")

from palpate.widget import Page  # noqa: E402


class Front:
    """A front end without a screen: what it says, and what it was told."""

    def __init__(self, page: Page) -> None:
        self.page, self.told = page, []
        page.send = lambda content, buffers=None: self.told.append(content)

    told: list[dict[str, Any]]

    def say(self, message: dict[str, Any]) -> dict[str, Any]:
        self.page._handle_custom_msg(message, [])
        return self.told[-1]


def touched() -> palpate.Loop:
    return palpate.Loop("uskin-4x4", skin="emulated")


def test_touches_go_to_the_loop_and_pictures_come_back() -> None:
    steps: list[palpate.Step] = []
    loop = touched()
    front = Front(Page(loop, steps.append))
    hello = front.say({"hello": 7})
    assert hello["touched"] and hello["now_us"] == 0
    assert len(hello["head"]["wires_mm"]) == len(loop.wires)
    front.say({"from": 7, "us": hello["head"]["quiet_us"] + 20_000, "fingers": []})
    for n in range(60):
        fingers = [[0, 0, 1000, -2000, 700, 19_500]] if n == 0 else []
        front.say({"from": 7, "us": 16_667, "fingers": fingers})
    last = json.loads(front.told[-1]["picture"])
    assert front.told[-1]["to"] == 7 and last["now_us"] == loop.time_us
    (contact,) = last["contacts"]
    assert np.hypot(contact["at_mm"][0] - 1, contact["at_mm"][1] + 2) < 1
    pictures = [json.loads(told["picture"]) for told in front.told[1:]]
    # What the pictures tell is what the steps have.
    felt = [felt for picture in pictures for felt in picture["felt"]]
    assert len(felt) == sum(len(step.felt) for step in steps) > 3
    assert sum(len(p["bursts"]) for p in pictures) == sum(len(step.stimuli) for step in steps)
    assert all(c is not None for c in last["counts"]) and len(last["warm"]) == len(loop.wires)
    front.say({"from": 7, "us": 16_667, "fingers": [[0, 0, 1000, -2000, 0, 19_500]]})
    front.say({"from": 7, "us": 500_000, "fingers": []})
    assert json.loads(front.told[-1]["picture"])["contacts"] == []


def test_a_page_changes_nothing_that_the_loop_does() -> None:
    def run(loop: palpate.Loop, step: Any) -> list[tuple[Any, ...]]:
        step(600_000)
        loop.touch([0.5, 1.0], 0.8)
        return [tuple(row) for row in step(1_500_000).stimuli]

    plain, shown = touched(), touched()
    front = Front(Page(shown))
    front.say({"hello": 1})

    def looked(until: int) -> palpate.Step:
        step = shown.advance(until)
        front.page.show()
        return step

    assert run(plain, plain.advance) == run(shown, looked) != []


def test_readings_that_are_pushed_are_shown() -> None:
    loop = palpate.Loop("uskin-4x4")
    front = Front(Page(loop))
    front.say({"hello": 1})
    assert [told.get("touched") for told in front.told] == [False, None]
    counts = np.full((16, 3), 30_000, np.uint16)
    for row in range(80):
        counts[:, 2] = 30_000 + (row + np.arange(16)) % 2
        counts[5, 2] += 600 * (row >= 60)
        loop.push(10_000 * (row + 1), counts)
    front.page.show()
    picture = json.loads(front.told[-1]["picture"])
    assert picture["now_us"] == 800_000 and picture["bursts"] and len(picture["contacts"]) == 1
    # Its time is the notebook's.
    count = len(front.told)
    front.page._handle_custom_msg({"from": 1, "us": 1000, "fingers": []}, [])
    assert len(front.told) == count and loop.time_us == 800_000


def test_of_two_views_the_newest_makes_time_go_on() -> None:
    loop = touched()
    front = Front(Page(loop))
    front.say({"hello": 1})
    front.say({"hello": 2})
    front.say({"from": 1, "us": 1000, "fingers": []})
    assert loop.time_us == 0
    assert front.say({"from": 2, "us": 1000, "fingers": []})["to"] == 2
    assert loop.time_us == 1000


@pytest.mark.parametrize(
    "message",
    [
        {"from": 1, "us": -1, "fingers": []},
        {"from": 1, "us": 1000},
        {"from": 1, "us": 1000, "fingers": [[0, 9, 0, 0, 1000, 8000]]},
        {"from": 1, "us": 1000, "fingers": ["finger"]},
        {"hello": "who"},
    ],
)
def test_what_no_page_says_is_told_in_a_sentence(message: dict[str, Any]) -> None:
    loop = touched()
    front = Front(Page(loop))
    front.say({"hello": 1})
    assert "expected" in front.say(message)["failed"] or "message of the page" in front.told[-1]["failed"]
    assert loop.time_us == 0


def test_a_closed_loop_is_told() -> None:
    loop = touched()
    front = Front(Page(loop))
    front.say({"hello": 1})
    loop.close()
    assert "closed" in front.say({"from": 1, "us": 1000, "fingers": []})["failed"]
