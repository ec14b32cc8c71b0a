"""Emulated chips, for drivers that are tested without a kernel."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from . import _palpate
from ._errors import InputError
from ._table import Table

__all__ = ["Pca9685"]

_BLOCK = 32


class Pca9685:
    """Emulated PCA9685 on an I2C bus of 400 kHz, with the face of ``smbus2.SMBus``.

    A driver that takes a bus takes this one. A transaction takes its time, :meth:`advance` lets more pass, and
    :meth:`edges` says what the outputs did. What no chip answers is ``OSError``, as on Linux.

    Args:
        addresses: The chips' addresses, 0x40 to 0x7F; one or several.
    """

    def __init__(self, addresses: int | Sequence[int] = 0x40) -> None:
        every = [addresses] if isinstance(addresses, int) else list(addresses)
        if not every or any(not 0x40 <= address <= 0x7F for address in every):
            raise InputError.of("addresses", "addresses from 0x40 to 0x7F", repr(addresses))
        if len(set(every)) != len(every):
            raise InputError.of("addresses", "every address once", repr(addresses))
        self._bus = _palpate.I2cBus(every)
        self._edges: list[tuple[int, int, int, bool]] = []

    @property
    def time_ns(self) -> int:
        """Virtual time, nanoseconds."""
        return self._bus.now_ns()

    def advance(self, us: float) -> None:
        """Advances virtual time by so many microseconds."""
        if not 0 <= us <= 1e12:
            raise InputError.of("us", "0 to 1e12 microseconds", repr(us))
        self._edges += self._bus.advance(self._bus.now_ns() + round(us * 1000))

    def edges(self) -> Table:
        """Edges of the outputs since the last call: time_ns, address, channel, high."""
        self.advance(0)
        kinds = [("time_ns", "<u8"), ("address", "|u1"), ("channel", "|u1"), ("high", "|b1")]
        found, self._edges = self._edges, []
        return np.array(found, dtype=kinds).view(Table)

    def outputs(self, address: int = 0x40) -> list[str]:
        """The outputs of a chip now: ``"high"``, ``"low"`` or ``"floating"``."""
        pins = self._bus.pins(address)
        if pins is None:
            raise InputError.of("address", "the address of a chip of this bus", hex(address))
        return pins

    def hazards(self, address: int = 0x40) -> list[tuple[int, str]]:
        """Hazardous accesses to a chip: time (ns) and description."""
        return self._bus.hazards(address)

    def write_byte(self, i2c_addr: int, value: int, force: bool | None = None) -> None:
        """As ``SMBus.write_byte``."""
        self._write(i2c_addr, [value])

    def write_byte_data(
        self, i2c_addr: int, register: int, value: int, force: bool | None = None
    ) -> None:
        """As ``SMBus.write_byte_data``."""
        self._write(i2c_addr, [register, value])

    def write_word_data(
        self, i2c_addr: int, register: int, value: int, force: bool | None = None
    ) -> None:
        """As ``SMBus.write_word_data``: the low byte first."""
        self._write(i2c_addr, [register, value & 0xFF, value >> 8])

    def write_i2c_block_data(
        self, i2c_addr: int, register: int, data: Sequence[int], force: bool | None = None
    ) -> None:
        """As ``SMBus.write_i2c_block_data``: at most 32 bytes."""
        if len(data) > _BLOCK:
            raise ValueError(f"Data length cannot exceed {_BLOCK} bytes")
        self._write(i2c_addr, [register, *data])

    def read_byte(self, i2c_addr: int, force: bool | None = None) -> int:
        """As ``SMBus.read_byte``: of the register that was named last."""
        return self._bus.transfer([(i2c_addr, None, 1)])[0][0]

    def read_byte_data(self, i2c_addr: int, register: int, force: bool | None = None) -> int:
        """As ``SMBus.read_byte_data``."""
        return self._read(i2c_addr, register, 1)[0]

    def read_word_data(self, i2c_addr: int, register: int, force: bool | None = None) -> int:
        """As ``SMBus.read_word_data``: the low byte first."""
        low, high = self._read(i2c_addr, register, 2)
        return low | high << 8

    def read_i2c_block_data(
        self, i2c_addr: int, register: int, length: int, force: bool | None = None
    ) -> list[int]:
        """As ``SMBus.read_i2c_block_data``: at most 32 bytes."""
        if length > _BLOCK:
            raise ValueError(f"Desired block length over {_BLOCK} bytes")
        return list(self._read(i2c_addr, register, length))

    def close(self) -> None:
        """As ``SMBus.close``; the chips stay."""

    def __enter__(self) -> Pca9685:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def _write(self, address: int, values: Sequence[int]) -> None:
        self._bus.transfer([(address, bytes(values), 0)])

    def _read(self, address: int, register: int, length: int) -> bytes:
        return self._bus.transfer([(address, bytes([register]), 0), (address, None, length)])[0]
