// An RP2040 (rp2040js) that runs an image of the driver unit over the rig's boards: node pico.mjs RP2040JS IMAGE, in the folder
// of the rig's pipes. It asks what images in QEMU ask by semihosting (core/unit/images/shared/src/rig/mod.rs): its I2C
// controller's signals, the level of GPIO 6, the packets of its serial port, its converter's codes, the current that its pins set.
import { openSync, readFileSync, readSync, writeSync } from "node:fs";
import { pathToFileURL } from "node:url";

const [library, image] = process.argv.slice(2);
const { ConsoleLogger, LogLevel, RP2040, USBCDC } = await import(pathToFileURL(library));

const BOOT = 0, OE = 1, RECEIVE = 3, SEND = 4, SIGNAL = 7, SENSORS = 8, BRIDGE = 9;
const START = 0, WRITE = 1, READ = 2, STOP = 3;
const DONE = 0, STUCK = 5;
// a bit at 400 kbit/s, and a byte with its acknowledgement
const BIT_NS = 2500, BYTE_NS = 9 * BIT_NS;
const CYCLE_NS = 8;
// between two looks for a datagram, and at the bridge's pins
const LOOK_NS = 500_000;
// a conversion of the converter
const CONVERSION_NS = 2000;
// all of the chip but its oscillators
const WHOLE = 0x1fffc;
const FLASH = 0x10000000, VECTORS = FLASH + 0x100;
const HOST = [192, 168, 7, 1], UNIT = [192, 168, 7, 2], PORT = 4000;

const questions = openSync("questions", "w");
const answers = openSync("answers", "r");

// --- the rig -----------------------------------------------------------------------------------------------
function exactly(length) {
  const bytes = Buffer.alloc(length);
  for (let done = 0; done < length; ) {
    const read = readSync(answers, bytes, done, length - done);
    if (read === 0) process.exit(0);
    done += read;
  }
  return bytes;
}

function ask(kind, argument = 0, bytes = Buffer.alloc(0)) {
  const head = Buffer.alloc(12);
  head.writeBigUInt64LE(BigInt(Math.round(now())), 0);
  head.writeUInt8(kind, 8);
  head.writeUInt8(argument, 9);
  head.writeUInt16LE(bytes.length, 10);
  writeSync(questions, Buffer.concat([head, bytes]));
  const answer = exactly(12);
  return { outcome: answer.readUInt8(8), bytes: exactly(answer.readUInt16LE(10)) };
}

// --- packets on the serial port: UDP in IP in SLIP ---------------------------------------------------------
const END = 0xc0, ESCAPE = 0xdb, ESCAPED = { 0xdc: END, 0xdd: ESCAPE };

function packet(datagram) {
  const bytes = Buffer.alloc(28 + datagram.length);
  bytes.set([0x45, 0, 0, 0, 0, 0, 0x40, 0, 64, 17, 0, 0, ...HOST, ...UNIT]);
  bytes.writeUInt16BE(bytes.length, 2);
  let sum = 0;
  for (let at = 0; at < 20; at += 2) sum += bytes.readUInt16BE(at);
  while (sum > 0xffff) sum = (sum & 0xffff) + (sum >>> 16);
  bytes.writeUInt16BE(~sum & 0xffff, 10);
  bytes.writeUInt16BE(PORT, 20);
  bytes.writeUInt16BE(PORT, 22);
  // its sum stays 0: none
  bytes.writeUInt16BE(8 + datagram.length, 24);
  bytes.set(datagram, 28);
  return bytes;
}

function line(bytes) {
  const escape = (byte) => (byte === END ? [ESCAPE, 0xdc] : byte === ESCAPE ? [ESCAPE, 0xdd] : [byte]);
  return [END, ...[...bytes].flatMap(escape), END];
}

// --- the machine, anew after each bite of its watchdog -----------------------------------------------------
const elf = readFileSync(image);
// nanoseconds of all starts before this one
let before = 0;
let chip;
function now() {
  return before + (chip ? chip.clock.nanos : 0);
}

function load(rp2040) {
  const at = elf.readUInt32LE(28), size = elf.readUInt16LE(42), count = elf.readUInt16LE(44);
  for (let n = 0; n < count; n++) {
    const part = at + n * size;
    const [type, offset, , address, length] = [0, 4, 8, 12, 16].map((field) => elf.readUInt32LE(part + field));
    if (type === 1 && length > 0) rp2040.flash.set(elf.subarray(offset, offset + length), address - FLASH);
  }
  rp2040.core.VTOR = VECTORS;
  rp2040.core.SP = rp2040.flashView.getUint32(VECTORS - FLASH, true);
  rp2040.core.PC = rp2040.flashView.getUint32(VECTORS - FLASH + 4, true) & ~1;
}

function boards(rp2040) {
  const i2c = rp2040.i2c[0];
  const after = (ns, done) => rp2040.clock.createAlarm(done).schedule(ns);
  const signal = (what, value, ns, done) =>
    after(ns, () => {
      const { outcome, bytes } = ask(SIGNAL, what, Buffer.from([value]));
      // held low for ever: the controller waits, and its program with it
      if (outcome !== STUCK) done(bytes[0]);
    });
  i2c.onStart = () => after(BIT_NS, () => i2c.completeStart());
  let target = 0, direction = 0;
  i2c.onConnect = (address, mode) => {
    [target, direction] = [address, mode];
    signal(START, (address << 1) | mode, BYTE_NS, (ack) => i2c.completeConnect(ack === 1));
  };
  // A controller with IC_RESTART_EN begins again where the direction changes (RP2040 data sheet, 4.3.10.2); rp2040js does not.
  const towards = (mode, then) => {
    if (direction === mode) return then();
    direction = mode;
    signal(START, (target << 1) | mode, BIT_NS + BYTE_NS, then);
  };
  i2c.onWriteByte = (byte) =>
    towards(0, () => signal(WRITE, byte, BYTE_NS, (ack) => i2c.completeWrite(ack === 1)));
  i2c.onReadByte = () => towards(1, () => signal(READ, 0, BYTE_NS, (byte) => i2c.completeRead(byte)));
  i2c.onStop = () => signal(STOP, 0, BIT_NS, () => i2c.completeStop());
  // a pin that drives nothing is pulled up
  let oe;
  const pin = rp2040.gpio[6];
  const level = () => {
    const high = pin.value === 0 ? 0 : 1;
    if (high !== oe) ask(OE, (oe = high));
  };
  pin.addListener(level);
  level();
}

// A MAX8521 on a Peltier module: SHDN on GPIO 7, CTLI behind a low pass on GPIO 8, 50 mOhm; thermistors on the first two channels.
function module(rp2040) {
  const { adc, pwm, gpio } = rp2040;
  adc.onADCRead = (channel) => {
    const codes = ask(SENSORS).bytes;
    const done = () => adc.completeADCRead(channel < 2 ? codes.readUInt16LE(2 * channel) : 0, false);
    rp2040.clock.createAlarm(done).schedule(CONVERSION_NS);
  };
  let given;
  return () => {
    const { cc, top } = pwm.channels[4];
    const volts = (3.3 * (cc & 0xffff)) / (top + 1);
    // its value is 1 where it is driven high; any other leaves the resistor to ground
    const milliamps = gpio[7].value === 1 ? Math.round(((volts - 1.5) / (10 * 0.05)) * 1000) : 0;
    if (milliamps === given) return;
    given = milliamps;
    const bytes = Buffer.alloc(8);
    bytes.writeInt32LE(milliamps, 0);
    // pins hold what they have
    bytes.writeUInt32LE(0xffffffff, 4);
    ask(BRIDGE, 0, bytes);
  };
}

function port(rp2040) {
  const cdc = new USBCDC(rp2040.usbCtrl);
  const waiting = [];
  let came = [], escaped = false;
  cdc.onSerialData = (bytes) => {
    for (const byte of bytes) {
      if (byte === END) {
        if (came.length > 28) ask(SEND, 0, Buffer.from(came.slice(28)));
        came = [];
      } else if (byte === ESCAPE) escaped = true;
      else {
        came.push(escaped ? ESCAPED[byte] : byte);
        escaped = false;
      }
    }
  };
  // The port's driver asks for bytes before rp2040js knows which endpoint is theirs, and not again until it has some.
  const asked = new Map();
  const give = () => {
    const size = asked.get(cdc.outEndpoint);
    if (size === undefined || waiting.length === 0) return;
    asked.delete(cdc.outEndpoint);
    rp2040.usbCtrl.endpointReadDone(cdc.outEndpoint, Uint8Array.from(waiting.splice(0, size)));
  };
  rp2040.usbCtrl.onEndpointRead = (endpoint, size) => {
    asked.set(endpoint, size);
    give();
  };
  return () => {
    if (waiting.length === 0 && cdc.initialized) {
      const { outcome, bytes } = ask(RECEIVE);
      if (outcome === DONE) waiting.push(...line(packet(bytes)));
    }
    give();
  };
}

function start() {
  const rp2040 = new RP2040();
  rp2040.logger = new ConsoleLogger(LogLevel.Error);
  load(rp2040);
  before = now();
  chip = rp2040;
  // the bits of the ring oscillator, which rp2040js has not: others after each start
  let seed = Number(ask(BOOT).bytes.readBigUInt64LE() & 0xffffffn) * 2654435761;
  const rosc = rp2040.peripherals[0x40060];
  rosc.readUint32 = (offset) => {
    seed = (Math.imul(seed, 1664525) + 1013904223) >>> 0;
    // status: on and stable; else the random bit
    return offset === 0x18 ? 0x80001000 : seed >>> 31;
  };
  rosc.writeUint32 = () => {};
  boards(rp2040);
  const flow = module(rp2040);
  flow();
  const look = port(rp2040);
  let bitten = false;
  const watchdog = rp2040.peripherals[0x40058];
  watchdog.onWatchdogTrigger = () => {
    // A counter that stands at 0 would set rp2040js's alarm for this very instant again, without end.
    watchdog.alarm.enable = false;
    // It resets what PSM's WDSEL names (RP2040 data sheet, 2.13), by which the hardware begins anew as this script does.
    bitten = (rp2040.peripherals[0x40010].wdsel & WHOLE) === WHOLE;
  };
  let next = LOOK_NS;
  while (!bitten) {
    const { core, clock } = rp2040;
    clock.tick(core.waiting ? clock.nanosToNextAlarm : core.executeInstruction() * CYCLE_NS);
    if (clock.nanos >= next) {
      next += LOOK_NS;
      flow();
      look();
    }
  }
}

for (;;) start();
