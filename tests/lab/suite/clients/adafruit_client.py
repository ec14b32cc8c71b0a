"""Adafruit's CircuitPython driver through Blinka on /dev/i2c-N: a pulse train on channel 3, then off."""
import sys
import time

from adafruit_extended_bus import ExtendedI2C
from adafruit_pca9685 import PCA9685

pwm = PCA9685(ExtendedI2C(int(sys.argv[1])))
pwm.frequency = 200
assert pwm.prescale_reg == 30, pwm.prescale_reg
pwm.channels[3].duty_cycle = 0x0640  # 100 of 4096 ticks
assert pwm.channels[3].duty_cycle >> 4 == 100
time.sleep(0.5)
pwm.channels[3].duty_cycle = 0
time.sleep(0.1)
pwm.deinit()
print("ok")
