// A bus (DW_apb_i2c, as controller) as the RP2040 has it: bits take their time by the clock's registers, and TX_EMPTY
// comes when the last byte is on the wires no more, or was given up. The emulator's own transfers take no time; its
// TX_EMPTY comes when a byte leaves the FIFO, and not at all if nobody acknowledged: the Pico's SDK then waits in vain.

import { I2CMode } from 'rp2040js';

const TX_EMPTY = 1 << 4;
const BYTE_BITS = 9; // with its acknowledgement
const HIGH_CYCLES_BESIDE = 7; // RP2040 datasheet, 4.3.14: SCL is high for HCNT + SPKLEN + 7 cycles,
const LOW_CYCLES_BESIDE = 1; // and low for LCNT + 1

// Put `device` on the bus `i2c` of an RP2040: connect(address, reads) and write(byte) return true to acknowledge, and
// read() returns a byte.
export function realI2c(i2c, mcu, device) {
  let then = null; // what follows when the bits on the wires have passed
  const passed = mcu.clock.createAlarm(() => {
    const next = then;
    then = null;
    next();
  });
  const after = (bits, next) => {
    const high = i2c.sclHighPeriod + i2c.spikelen + HIGH_CYCLES_BESIDE;
    const low = i2c.sclLowPeriod + LOW_CYCLES_BESIDE;
    then = next;
    passed.schedule((bits * (high + low) * 1e9) / mcu.clkSys);
  };

  const raise = i2c.setInterrupts.bind(i2c);
  i2c.setInterrupts = (mask) => raise(then ? mask & ~TX_EMPTY : mask);
  const empty = () => {
    if (i2c.txFIFO.itemCount <= i2c.txThreshold) raise(TX_EMPTY);
  };
  const abort = i2c.abort.bind(i2c);
  i2c.abort = (reason) => {
    abort(reason);
    empty();
  };

  i2c.onStart = () => after(1, () => i2c.completeStart());
  i2c.onConnect = (address, mode) =>
    after(BYTE_BITS, () => i2c.completeConnect(device.connect(address, mode === I2CMode.Read)));
  i2c.onWriteByte = (value) =>
    after(BYTE_BITS, () => {
      empty();
      i2c.completeWrite(device.write(value));
    });
  i2c.onReadByte = () =>
    after(BYTE_BITS, () => {
      empty();
      i2c.completeRead(device.read());
    });
  i2c.onStop = () => after(1, () => i2c.completeStop());
}
