// The RP2040's flash cache: 16 KB, two ways, lines of 8 bytes, the least recently used line gives way
// (RP2040 datasheet, 2.6.3). The emulator itself takes flash to be as fast as RAM.
//
// A line that is missing takes 28 periods of the flash's clock: 8 for address and mode, 4 dummies, 16 for 8 bytes over
// four wires. Four more cycles of the processor's clock are set so that MicroPython's bm_chaos benchmark takes as long
// as it does on a board: see test_calibration.py.

const SETS = 1024;
const LINE_BITS = 3;
const SERIAL_CLOCKS = 28;
const CYCLES_BESIDE = 4;

export class FlashCache {
  constructor() {
    this.lines = new Int32Array(2 * SETS); // what each way of each set holds
    this.older = new Uint8Array(SETS); // the way that gives way next
    this.missing = 0;
    this.forget();
  }

  forget() {
    this.lines.fill(-1);
  }

  // The processor reads this address. Counts a line that has to be fetched.
  read(address) {
    const line = (address & 0xffffff) >> LINE_BITS;
    const set = line & (SETS - 1);
    if (this.lines[set] === line) {
      this.older[set] = 1;
    } else if (this.lines[set + SETS] === line) {
      this.older[set] = 0;
    } else {
      const way = this.older[set];
      this.lines[set + way * SETS] = line;
      this.older[set] = 1 - way;
      this.missing++;
    }
  }

  // Cycles of the processor's clock that the lines fetched since the last call took. `divider` is that of the flash.
  takeCycles(divider) {
    const cycles = this.missing * (SERIAL_CLOCKS * divider + CYCLES_BESIDE);
    this.missing = 0;
    return cycles;
  }
}
