// A flash chip behind the boot ROM's functions: takes the time that a W25Q16JV takes, and can lose power in any of its
// operations, half-way through.

import { ERASE, PROGRAM } from './bootrom.mjs';

const ERASE_NS = 45e6; // a sector of 4096 bytes
const PROGRAM_NS = 0.4e6; // a page of 256 bytes

export class Flash {
  constructor() {
    this.operations = 0;
    this.cutAt = 0; // number of the operation in which the power fails; 0 for none
  }

  // Serve the breakpoint `code` of a patched boot ROM. Returns true if the power failed.
  serve(code, mcu) {
    if (code !== ERASE && code !== PROGRAM) throw new Error(`breakpoint ${code} at ${mcu.core.PC.toString(16)}`);
    const [at, second, third] = mcu.core.registers;
    const cut = ++this.operations === this.cutAt;
    const size = code === ERASE ? second : third;
    const done = cut ? size >> 1 : size;
    if (code === ERASE) {
      mcu.flash.fill(0xff, at, at + done);
      mcu.clock.tick((ERASE_NS * size) / 4096);
    } else {
      for (let i = 0; i < done; i++) mcu.flash[at + i] &= mcu.readUint8(second + i); // bits only go from 1 to 0
      mcu.clock.tick((PROGRAM_NS * size) / 256);
    }
    return cut;
  }
}
