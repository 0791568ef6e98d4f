// The UART (PL011) as the RP2040 has it: FIFOs of 32 bytes with their levels and interrupts, and a line that takes ten
// bits' time for a byte. The emulator's own sends a byte at once.

const DATA = 0x00;
const FLAGS = 0x18;
const LEVELS = 0x34;
const CLEAR = 0x44;
const RX_FULL = 1 << 6;
const RX_EMPTY = 1 << 4;
const TX_FULL = 1 << 5;
const TX_EMPTY = 1 << 7;
const BUSY = 1 << 3;
const TX_INTERRUPT = 1 << 5;
const RX_INTERRUPT = 1 << 4;
const TIMEOUT_INTERRUPT = 1 << 6;
const FIFO = 32;
const LEVEL = [4, 8, 16, 24, 28, 28, 28, 28]; // bytes at which an interrupt comes, by the three bits of a level
const HALF_FULL = 0x12; // both levels, after a reset
const TIMEOUT_BITS = 32;

// Make `uart` of an RP2040 real. Returns {receive(bytes), sent}: bytes to the board, and an array of those from it.
export function realUart(uart, mcu) {
  const line = { sent: [], lost: 0 };
  const arriving = [];
  const leaving = [];
  let levels = HALF_FULL;
  let onTheWay = false;
  let sending = false;
  const byteNs = () => 1e10 / Math.max(300, uart.baudRate || 115200);
  const check = () => mcu.setInterrupt(uart.irq, !!(uart.interruptStatus & uart.interruptMask));
  const txLevel = () => LEVEL[levels & 7];
  const rxLevel = () => LEVEL[(levels >> 3) & 7];

  const timeout = mcu.clock.createAlarm(() => {
    if (!uart.rxFIFO.empty) uart.interruptStatus |= TIMEOUT_INTERRUPT;
    check();
  });
  const sent = mcu.clock.createAlarm(() => {
    line.sent.push(leaving.shift());
    sending = leaving.length > 0;
    if (sending) sent.schedule(byteNs());
    if (leaving.length === txLevel() || !sending) uart.interruptStatus |= TX_INTERRUPT;
    check();
  });
  const arrived = mcu.clock.createAlarm(() => {
    const value = arriving.shift();
    if (uart.rxFIFO.full) line.lost++;
    else uart.rxFIFO.push(value);
    if (uart.rxFIFO.itemCount >= rxLevel()) uart.interruptStatus |= RX_INTERRUPT;
    timeout.schedule((byteNs() / 10) * TIMEOUT_BITS);
    check();
    onTheWay = arriving.length > 0;
    if (onTheWay) arrived.schedule(byteNs());
  });

  const take = () => {
    if (uart.rxFIFO.empty) return 0;
    const value = uart.rxFIFO.pull();
    if (uart.rxFIFO.itemCount < rxLevel()) uart.interruptStatus &= ~RX_INTERRUPT;
    if (uart.rxFIFO.empty) uart.interruptStatus &= ~TIMEOUT_INTERRUPT;
    check();
    return value;
  };
  const put = (value) => {
    leaving.push(value & 0xff);
    if (leaving.length > txLevel()) uart.interruptStatus &= ~TX_INTERRUPT;
    check();
    if (!sending) {
      sending = true;
      sent.schedule(byteNs());
    }
  };

  const read = uart.readUint32.bind(uart);
  const write = uart.writeUint32.bind(uart);
  uart.checkInterrupts = check;
  uart.readUint32 = (offset) => {
    if (offset === DATA) return take();
    if (offset === LEVELS) return levels;
    if (offset !== FLAGS) return read(offset);
    const rx = (uart.rxFIFO.full ? RX_FULL : 0) | (uart.rxFIFO.empty ? RX_EMPTY : 0);
    return rx | (leaving.length ? BUSY : TX_EMPTY) | (leaving.length >= FIFO ? TX_FULL : 0);
  };
  uart.writeUint32 = (offset, value) => {
    if (offset === DATA) put(value);
    else if (offset === LEVELS) levels = value;
    else if (offset === CLEAR) {
      uart.interruptStatus &= ~uart.rawWriteValue;
      check();
    } else write(offset, value);
  };
  line.receive = (bytes) => {
    for (const value of bytes) arriving.push(value);
    if (!onTheWay && arriving.length) {
      onTheWay = true;
      arrived.schedule(byteNs());
    }
  };
  return line;
}
