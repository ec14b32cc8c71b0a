"""The loop, held open."""

from __future__ import annotations

import signal
import subprocess
import sys
import threading
import time

import numpy as np
import pytest

import palpate


def still(rows: int = 60) -> np.ndarray[tuple[int, ...], np.dtype[np.uint16]]:
    counts = np.full((rows, 16, 3), 30_000, dtype=np.uint16)
    counts[:, :, 2] += ((np.arange(rows)[:, None] + np.arange(16)) % 2).astype(np.uint16)
    return counts


def pressed(taxel: int, rows: int) -> np.ndarray[tuple[int, ...], np.dtype[np.uint16]]:
    counts = still(rows)
    counts[:, taxel, 2] += 600
    return counts


def test_readings_are_felt() -> None:
    loop = palpate.Loop("uskin-4x4")
    assert loop.shapes == [(16, 3)]
    felt, stimuli, contacts = [], 0, 0
    for row, counts in enumerate(still()):
        loop.push(10_000 * row + 10_000, counts)
    for row, counts in enumerate(pressed(5, 140), 60):
        step = loop.push(10_000 * row + 10_000, counts)
        assert step.time_us == loop.time_us == 10_000 * row + 10_000
        contacts += len(step.contacts)
        stimuli += len(step.stimuli)
        felt += [tuple(f) for f in step.felt[["x_mm", "y_mm"]][step.felt["felt"]]]
    assert contacts == 140 and stimuli > 10
    # Taxel 5 is in the second row and the second column.
    assert felt and np.hypot(felt[-1][0] - step.contacts["x_mm"][0], felt[-1][1]) < 10
    assert abs(step.contacts["x_mm"][0] + 2.35) < 1e-6
    assert abs(step.contacts["y_mm"][0] - 2.35) < 1e-6
    warm = loop.temperatures()
    assert len(warm) == 8 and warm["wire_c"].max() > 34 and np.ptp(warm["skin_c"]) > 1


def test_forces_are_felt_through_the_emulated_skin() -> None:
    with palpate.Loop("uskin-4x4", skin="emulated") as loop:
        loop.advance(500_000)
        loop.touch([1.0, -2.0], 0.7, diameter_mm=19.45)
        step = loop.advance(900_000)
        last = step.contacts[step.contacts["time_us"] > 700_000]
        away = np.hypot(last["x_mm"] - 1.0, last["y_mm"] + 2.0)
        assert len(last) > 10 and np.sqrt(np.mean(away**2)) < 0.3
        loop.touch([], [])
        loop.advance(1_100_000)
        assert len(loop.advance(1_300_000).contacts) == 0


@pytest.mark.parametrize("bench", ["emulated", "lra-8", "voice-coil-8", "lra-grid-4x3"])
def test_a_loop_has_the_schedule_of_a_run_on_wires_and_on_motors(bench: str) -> None:
    rows = np.concatenate([still(), pressed(5, 140)])
    times = 10_000 * np.arange(1, len(rows) + 1)
    run = palpate.run(replay=rows, time_us=times, layout="uskin-4x4", bench=bench, set={"compression.levels": "dynamic"})
    loop = palpate.Loop("uskin-4x4", bench)
    steps = [loop.push(int(at), counts) for at, counts in zip(times, rows, strict=True)]
    columns = ["time_us", "wire", "width", "requested", "until_us", "reason"]
    stepped = np.concatenate([step.stimuli[columns] for step in steps])
    ran = run.stimuli[columns]
    assert len(stepped) > 20 and (stepped["width"] > 0).any()
    assert stepped.tolist() == ran[ran["time_us"] <= stepped["time_us"].max()].tolist()
    felt = np.concatenate([step.felt for step in steps])
    assert felt["felt"].sum() > 10
    # Motors are looked at in steps that begin at each turn, and a loop's turns lie elsewhere than a run's.
    near = 0.0 if bench == "emulated" else 0.1
    for column in ("x_mm", "y_mm", "level_db"):
        assert np.abs(felt[column] - run.felt[column][: len(felt)]).max() <= near, column


@pytest.mark.parametrize("bench", ["lra-8", "voice-coil-8", "lra-grid-4x3"])
def test_motors_shake_under_touches_and_have_nothing_of_wires(bench: str) -> None:
    with palpate.Loop("uskin-4x4", bench, skin="emulated") as loop:
        loop.advance(700_000)
        notes = [str(text) for text in loop.hot_pass().events["text"]]
        assert notes == ["hot pass: none: motors have no wires to heat"]
        with pytest.raises(palpate.InputError, match="expected a bench of wires, found motors"):
            loop.temperatures()
        loop.touch([1.0, -2.0], 0.7)
        step = loop.advance(2_000_000)
        assert step.felt["felt"].all() and step.felt["level_db"].min() > 20
        loop.touch([], [])
        loop.advance(2_300_000)
        assert len(loop.advance(2_800_000).stimuli) == 0
    own = palpate.Loop("uskin-4x4", bench, skin="emulated", illusion="own", set={"illusion.model": "energy"})
    own.advance(700_000)
    own.touch([0, 0], 0.7)
    own.activate([0.5] + [0] * (len(own.wires) - 1))
    stimuli = own.advance(1_500_000).stimuli
    assert set(stimuli["wire"][stimuli["width"] > 0]) == {0}


def test_the_skin_is_zeroed_at_rest_and_under_a_touch_only_when_forced() -> None:
    def played(rows: np.ndarray[tuple[int, ...], np.dtype[np.uint16]]) -> list[int]:
        return [len(loop.push(loop.time_us + 10_000, counts).contacts) for counts in rows]

    def said(step: palpate.Step) -> list[str]:
        return [str(text) for text in step.events["text"]]

    # Recordings without a scene follow drift: their reference is a state that can be taken anew.
    loop = palpate.Loop("uskin-4x4")
    assert sum(played(still())) == 0
    assert played(pressed(5, 20))[-1] == 1
    refused = said(loop.rezero())
    assert any(text.startswith("rezero: ") and "taken anew" not in text for text in refused)
    assert played(pressed(5, 20))[-1] == 1
    taken = said(loop.rezero(forced=True))
    assert "rezero: the reference of the skin is taken anew" in taken
    # What presses now is rest, and another taxel is a contact.
    assert sum(played(pressed(5, 80))[40:]) == 0


def test_two_loops_say_the_same() -> None:
    def play() -> list[bytes]:
        loop = palpate.Loop("uskin-4x4", seed=3)
        counts = [*still(), *pressed(6, 60)]
        steps = [loop.push(10_000 * (n + 1), c) for n, c in enumerate(counts)]
        return [s.stimuli.tobytes() + s.felt.tobytes() + s.edges.tobytes() for s in steps]

    assert play() == play()


def test_a_loop_goes_from_thread_to_thread_and_holds_one_at_a_time() -> None:
    loop = palpate.Loop("uskin-4x4", skin="emulated")
    errors: list[BaseException] = []

    def long() -> None:
        try:
            loop.advance(20_000_000)
        except palpate.Error as error:
            errors.append(error)

    thread = threading.Thread(target=long)
    thread.start()
    busy = 0
    while thread.is_alive():
        try:
            loop.temperatures()
        except palpate.BusyError as error:
            assert "one thread at a time" in str(error)
            busy += 1
    thread.join()
    assert busy > 0
    assert loop.time_us == 20_000_000 or errors


def test_ctrl_c_ends_a_long_advance() -> None:
    code = """
import palpate
loop = palpate.Loop("uskin-4x4", skin="emulated")
print("begun", flush=True)
try:
    loop.advance(10**12)
except KeyboardInterrupt:
    print("interrupted", 0 < loop.time_us < 10**12)
"""
    program = subprocess.Popen([sys.executable, "-c", code], stdout=subprocess.PIPE, text=True)
    assert program.stdout is not None
    assert program.stdout.readline() == "begun\n"
    time.sleep(0.3)
    program.send_signal(signal.SIGINT)
    assert program.communicate(timeout=20)[0] == "interrupted True\n"


@pytest.mark.parametrize(
    ("work", "words"),
    [
        (lambda l: l.push(1, still(1)[0][:, :2]), "shape"),
        (lambda l: l.push(1, still(1)[0], module=1), "module: expected 0 to 0"),
        (lambda l: l.push(-1, still(1)[0]), "time_us"),
        (lambda l: l.push(1, np.full((16, 3), 0.4)), "newtons"),
        (lambda l: (l.push(10, still(1)[0]), l.push(10, still(1)[0])), "more than 10 us"),
        (lambda l: (l.advance(50_000), l.advance(10)), "from 50000 us on"),
        (lambda l: l.touch([0, 0], 1.0), 'skin="emulated"'),
        (lambda l: (l.close(), l.advance(10)), "closed"),
        (lambda l: palpate.Loop("none-such"), "none-such"),
        (lambda l: palpate.Loop(skin="real"), "pushed"),  # type: ignore[arg-type]
        (lambda l: palpate.Loop("uskin-4x4", skin="emulated").push(1, still(1)[0]), 'skin="pushed"'),
        (lambda l: palpate.Loop("uskin-4x4", skin="emulated").touch([[0, 0]], [np.nan]), "forces"),
        (lambda l: palpate.Loop("uskin-4x4", skin="emulated").touch([[0, 0, 0]], [1]), "places"),
        (lambda l: palpate.Loop("uskin-4x4", skin="emulated").touch([[0, np.inf]], [1]), "places"),
        (lambda l: palpate.Loop("uskin-4x4", skin="emulated").touch([0, 0], 1, module=1), "module"),
    ],
)
def test_bad_input_says_what_was_expected(work: object, words: str) -> None:
    with pytest.raises(palpate.InputError, match=words):
        work(palpate.Loop("uskin-4x4"))  # type: ignore[operator]
