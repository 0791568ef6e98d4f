// A Raspberry Pi Pico: RP2040, flash with its cache, UARTs, encoders on its I2C, USB serial port, resets. Its time passes
// in run() only.

import { ConsoleLogger, LogLevel, Simulator } from 'rp2040js';

import { As5600 } from './as5600.mjs';
import { patched } from './bootrom.mjs';
import { Console } from './console.mjs';
import { Flash } from './flash.mjs';
import { FlashCache } from './flash_cache.mjs';
import { realI2c } from './i2c.mjs';
import { realUart } from './uart.mjs';

const START = 0x10000000; // second stage of the boot, in flash
const WATCHDOG = 0x40058;
const FLASH_INTERFACE = 0x18000;
const STACK_BOTTOM = 0x20040000; // of core 0: the banks SCRATCH_X and SCRATCH_Y
const STACK_TOP = 0x20042000;
const UNPOWERED = 0xa5; // what RAM holds after a loss of power, say
const BATCH = 400; // instructions between two looks at console and stop conditions
const LONGEST_SLEEP_NS = 1e5;

export class Board {
  constructor(bootrom, collect) {
    this.bootrom = patched(bootrom);
    this.collect = collect; // address of MicroPython's gc_collect, 0 if unknown
    this.flash = new Flash();
    this.cache = new FlashCache();
    this.encoders = [new As5600(), new As5600()]; // one on each bus, not connected
    this.offset = 0; // time at which the board was reset last [ns]
    this.resets = [];
    this.collections = []; // [start, duration] in ns
    this.deepest = STACK_TOP;
    this.feeds = []; // times at which the watchdog was fed [ns]
    this.build(null);
  }

  now() {
    return this.offset + this.clock.nanos;
  }

  build(kept) {
    const simulator = new Simulator();
    const mcu = (this.mcu = simulator.rp2040);
    this.clock = simulator.clock;
    mcu.logger = new ConsoleLogger(LogLevel.Error);
    mcu.loadBootrom(this.bootrom);
    this.watchdog = mcu.peripherals[WATCHDOG];
    if (kept) {
      mcu.sram.set(kept.sram);
      mcu.flash.set(kept.flash);
      this.watchdog.scratchData.set(kept.scratch);
      this.watchdog.reason = kept.reason;
    }
    this.event = null;
    this.watchdog.onWatchdogTrigger = () => {
      this.watchdog.alarm.enable = false;
      this.watchdog.timer.enable = false;
      this.event = this.watchdog.reason === 1 ? 'watchdog' : 'reset';
    };
    const feed = this.watchdog.timer.set.bind(this.watchdog.timer);
    this.watchdog.timer.set = (value) => {
      feed(value);
      this.feeds.push(this.now());
    };
    mcu.onBreak = (code) => {
      this.cache.forget();
      if (this.flash.serve(code, mcu)) this.event = 'cut';
    };
    this.cycleNs = 1e9 / mcu.clkSys;
    mcu.addClockListener((hz) => {
      this.cycleNs = 1e9 / hz;
    });
    this.line = realUart(mcu.uart[0], mcu);
    realUart(mcu.uart[1], mcu);
    mcu.i2c.forEach((bus, index) => realI2c(bus, mcu, this.encoders[index]));
    this.console = new Console(mcu.usbCtrl);
    this.readThroughCache();
    this.collectingSince = null;
    mcu.core.PC = START;
  }

  // Reads of flash go through the cache, and those of flash and RAM the short way.
  readThroughCache() {
    const { mcu, cache } = this;
    const { flash, flash16, flashView, sram, sramView } = mcu;
    cache.forget();
    const others = [mcu.readUint8.bind(mcu), mcu.readUint16.bind(mcu), mcu.readUint32.bind(mcu)];
    mcu.readUint8 = (address) => {
      if (address >>> 24 === 0x10) {
        cache.read(address);
        return flash[address & 0xffffff];
      }
      return address >>> 18 === 0x800 ? sram[address & 0x3ffff] : others[0](address);
    };
    mcu.readUint16 = (address) => {
      if (address >>> 24 === 0x10) {
        cache.read(address);
        return flash16[(address & 0xffffff) >> 1];
      }
      return address >>> 18 === 0x800 ? sramView.getUint16(address & 0x3ffff, true) : others[1](address);
    };
    mcu.readUint32 = (address) => {
      if (address >>> 24 === 0x10 && !(address & 3)) {
        cache.read(address);
        return flashView.getUint32(address & 0xffffff, true);
      }
      return address >>> 18 === 0x800 && !(address & 3) ? sramView.getUint32(address & 0x3ffff, true) : others[2](address);
    };
  }

  // Start again: by 'power', after which RAM holds nothing, 'watchdog' or 'reset' (machine.reset()).
  restart(cause) {
    const kept = {
      sram: this.mcu.sram.slice(), flash: this.mcu.flash,
      scratch: this.watchdog.scratchData.slice(), reason: this.watchdog.reason,
    };
    if (cause === 'power') {
      kept.sram.fill(UNPOWERED);
      kept.scratch.fill(0);
      kept.reason = 0;
    }
    this.resets.push([cause, this.now()]);
    this.offset = this.now();
    this.build(kept);
  }

  // Let time pass until `untilNs`, a reset, or `quantumNs` after the first byte that the board sends, where given.
  run(untilNs, quantumNs) {
    let stop = untilNs;
    let heard = !quantumNs;
    while (!this.event && this.now() < stop) {
      this.runBatch(stop);
      this.console.pump();
      if (!heard && this.line.sent.length) {
        heard = true;
        stop = Math.min(untilNs, this.now() + quantumNs);
      }
    }
    const event = this.event;
    this.event = null;
    if (event) this.restart(event === 'cut' ? 'power' : event);
    return event ?? 'time';
  }

  runBatch(stop) {
    const { core } = this.mcu;
    const flashInterface = this.mcu.peripherals[FLASH_INTERFACE];
    for (let i = 0; i < BATCH && !this.event; i++) {
      if (core.waiting) {
        const next = this.clock.nanosToNextAlarm;
        const left = stop - this.now();
        if (left <= 0) return;
        this.clock.tick(Math.max(1, Math.min(next > 0 ? next : LONGEST_SLEEP_NS, left)));
        if (core.interruptsUpdated && core.checkForInterrupts()) core.waiting = false;
        i += 20;
        continue;
      }
      const cycles = core.executeInstruction();
      const fetching = this.cache.missing ? this.cache.takeCycles(flashInterface.baudr || 2) : 0;
      this.clock.tick((cycles + fetching) * this.cycleNs);
      this.watch(core);
    }
  }

  // What no program on the board can tell: the depth of the stack, and when garbage is collected.
  watch(core) {
    const pointer = core.registers[13];
    if (pointer < this.deepest && pointer > STACK_BOTTOM - 0x1000) this.deepest = pointer;
    if (core.PC === this.collect && this.collectingSince === null) {
      this.collectingSince = this.now();
      this.returnsTo = core.registers[14] & ~1;
    } else if (this.collectingSince !== null && core.PC === this.returnsTo) {
      this.collections.push([this.collectingSince, this.now() - this.collectingSince]);
      this.collectingSince = null;
    }
  }

  stackUsed() {
    return STACK_TOP - this.deepest;
  }
}
