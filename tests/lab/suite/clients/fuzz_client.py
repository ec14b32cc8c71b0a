"""Random ioctls on an I2C node: plausible transactions, malformed ones, and ones that are none at all.

Counts what came back; anything but a result or an errno ends this program, and a hang ends the test.
Usage: fuzz_client.py N COUNT
"""
import ctypes
import fcntl
import os
import random
import struct
import sys

I2C_SLAVE, I2C_FUNCS, I2C_RDWR, I2C_SMBUS = 0x0703, 0x0705, 0x0707, 0x0720
OTHERS = [0x0701, 0x0704, 0x0708]  # retries, ten-bit, PEC
number, count = int(sys.argv[1]), int(sys.argv[2])
dice = random.Random(1)
node = os.open(f"/dev/i2c-{number}", os.O_RDWR)
libc = ctypes.CDLL(None, use_errno=True)


def address():
    return dice.choice([0x40, 0x40, 0x40, 0x70, 0x00, 0x41, dice.randrange(0x80), dice.randrange(0x10000)])


def length():
    return dice.choice([0, 1, 2, 5, 33, 65, dice.randrange(300), dice.randrange(0x10000) if dice.random() < 0.02 else 3])


def transfer():
    """I2C_RDWR with 0 to 44 messages; some have wild flags, some point nowhere."""
    kept, messages = [], b""
    amount = dice.choice([1, 1, 1, 2, 2, 2, 3, 0, 44])
    for n in range(min(amount, 43)):
        size = length()
        buffer = ctypes.create_string_buffer(bytes([dice.choice([0, 6, 0xFE])]) + dice.randbytes(size), size + 1)
        kept.append(buffer)
        flags = dice.choice([0, 1, n & 1, dice.randrange(0x10000) if dice.random() < 0.2 else 0])
        where = 8 if dice.random() < 0.02 else ctypes.addressof(buffer)
        messages += struct.pack("=HHHxxQ", address(), flags, size, where)
    block = ctypes.create_string_buffer(messages or b"\0" * 16)
    argument = ctypes.create_string_buffer(struct.pack("=QI4x", ctypes.addressof(block), amount))
    return libc.ioctl(node, I2C_RDWR, argument), kept


def smbus():
    """I2C_SMBUS of any size, command and direction on an address that may be free."""
    try:
        fcntl.ioctl(node, I2C_SLAVE, address())
    except OSError:
        pass
    data = ctypes.create_string_buffer(bytes([length() & 0xFF]) + dice.randbytes(33), 34)
    where = 0 if dice.random() < 0.05 else ctypes.addressof(data)
    argument = struct.pack("=BBxxIQ", dice.choice([0, 1, 0, 1, dice.randrange(256)]), dice.randrange(256), dice.randrange(11), where)
    return libc.ioctl(node, I2C_SMBUS, ctypes.create_string_buffer(argument)), data


def plain():
    """read and write without any ioctl."""
    if dice.random() < 0.5:
        return libc.write(node, dice.randbytes(length() or 1), ctypes.c_size_t(dice.randrange(1, 70))), None
    buffer = ctypes.create_string_buffer(9000)
    return libc.read(node, buffer, ctypes.c_size_t(length() % 9000)), None


def nothing():
    """Requests that set options, with any value, and unknown requests."""
    request = dice.choice(OTHERS + [dice.randrange(0x0700, 0x0730)])
    if request in (I2C_FUNCS, I2C_RDWR, I2C_SMBUS, 0x0702):
        return 0, None
    return libc.ioctl(node, request, ctypes.c_ulong(dice.choice([0, 1, dice.randrange(1 << 32)]))), None


done = failed = 0
for _ in range(count):
    result, _kept = dice.choice([transfer, transfer, smbus, smbus, plain, nothing])()
    done += result >= 0
    failed += result < 0
    if dice.random() < 0.1:  # options off again, or nothing would get through any more
        for request in (0x0704, 0x0708):
            libc.ioctl(node, request, ctypes.c_ulong(0))
print(f"{count} calls, {done} done, {failed} refused")
assert done > count // 10
