"""smbus2 on the served node: every kind of transaction that a PCA9685 understands."""
import errno
import sys

from smbus2 import SMBus, i2c_msg

bus = SMBus(int(sys.argv[1]))
CHIP, ALL_CALL, MODE1, LED0, ALL_OFF_H, PRE_SCALE = 0x40, 0x70, 0x00, 0x06, 0xFD, 0xFE

assert bus.read_byte_data(CHIP, PRE_SCALE) == 0x1E
bus.write_byte_data(CHIP, MODE1, 0x31)
bus.write_byte_data(CHIP, PRE_SCALE, 100)
assert bus.read_byte_data(CHIP, PRE_SCALE) == 100
bus.write_byte_data(CHIP, MODE1, 0x21)
# A byte alone sets the pointer; a byte alone reads there.
bus.write_byte(CHIP, PRE_SCALE)
assert bus.read_byte(CHIP) == 100
bus.write_word_data(CHIP, LED0, 0x0F23)
assert bus.read_word_data(CHIP, LED0) == 0x0F23
bus.write_i2c_block_data(CHIP, LED0, list(range(1, 33)))
pointer, data = i2c_msg.write(CHIP, [LED0]), i2c_msg.read(CHIP, 32)
bus.i2c_rdwr(pointer, data)
assert list(data) == [b & 0x1F if i % 2 else b for i, b in enumerate(range(1, 33))], list(data)
# All sixteen channels in one message of 65 bytes, longer than a report of the bridge, and back.
channels = [0, 0, 100, 0] * 16
bus.i2c_rdwr(i2c_msg.write(CHIP, [LED0] + channels))
pointer, data = i2c_msg.write(CHIP, [LED0]), i2c_msg.read(CHIP, 64)
bus.i2c_rdwr(pointer, data)
assert list(data) == channels, list(data)
# Everything off through the all-call address.
bus.write_byte_data(ALL_CALL, ALL_OFF_H, 0x10)
assert bus.read_byte_data(CHIP, LED0 + 3) == 0x10
try:
    bus.read_byte_data(0x41, 0)
    sys.exit("a chip answered at 0x41")
except OSError as error:
    assert error.errno == errno.ENXIO, error
print("ok")
