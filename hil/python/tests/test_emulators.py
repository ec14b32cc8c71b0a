"""An emulated chip under a driver in Python."""

from __future__ import annotations

import numpy as np
import pytest

import palpate
from palpate.emulators import Pca9685

MODE1, PRE_SCALE, LED0 = 0x00, 0xFE, 0x06


def test_a_driver_in_python_drives_the_chip() -> None:
    with Pca9685() as bus:
        assert bus.read_byte_data(0x40, MODE1) == 0x11
        bus.write_byte_data(0x40, PRE_SCALE, 30)
        bus.write_byte_data(0x40, MODE1, 0x20)
        bus.advance(1000)
        # Output 2: on at tick 0, off at 1024, a quarter of a period.
        bus.write_i2c_block_data(0x40, LED0 + 4 * 2, [0, 0, 0x00, 0x04])
        assert bus.read_i2c_block_data(0x40, LED0 + 4 * 2, 4) == [0, 0, 0, 4]
        assert bus.read_word_data(0x40, LED0 + 4 * 2 + 2) == 0x400
        bus.edges()
        bus.advance(60_000)
        edges = bus.edges()
        assert set(edges["channel"]) == {2}
        rises, falls = edges["time_ns"][edges["high"]], edges["time_ns"][~edges["high"]]
        period = float(np.median(np.diff(rises)))
        assert period == pytest.approx(1e9 / 196.89, rel=1e-3)
        falls = falls[falls > rises[0]]
        assert float(np.median(falls - rises[: len(falls)])) == pytest.approx(period / 4, rel=1e-3)
        assert bus.outputs()[3] == "low" and bus.hazards() == []


def test_what_no_chip_answers_is_an_error_as_on_linux() -> None:
    bus = Pca9685([0x40, 0x41])
    with pytest.raises(OSError) as error:
        bus.read_byte_data(0x50, 0)
    assert error.value.errno == 121
    for wrong in (0x20, [], [0x40, 0x40]):
        with pytest.raises(palpate.InputError, match="addresses"):
            Pca9685(wrong)
    with pytest.raises(palpate.InputError, match="us"):
        bus.advance(float("nan"))
    with pytest.raises(ValueError, match="32"):
        bus.read_i2c_block_data(0x40, 0, 33)
