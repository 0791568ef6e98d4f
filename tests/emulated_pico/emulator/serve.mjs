// Serves an emulated Pico over standard input and output: one request and one answer, each a line of JSON.
//
//   node serve.mjs BOOTROM IMAGE FILESYSTEM|- GC_COLLECT
//
// BOOTROM, IMAGE and FILESYSTEM are raw binary files, GC_COLLECT the address of MicroPython's gc_collect (0: unknown).
// Requests are the methods below with their arguments by name; bytes are in base64, times in ns.

import fs from 'node:fs';
import readline from 'node:readline';

import { Board } from './board.mjs';

const RAM = 0x20000000;
const FILESYSTEM_BYTES = 352 * 4096;
const FLASH_BYTES = 2 * 1024 * 1024;

const [bootrom, image, filesystem, collect] = process.argv.slice(2);
const board = new Board(fs.readFileSync(bootrom), Number(collect));
board.mcu.flash.set(fs.readFileSync(image), 0);
if (filesystem !== '-') board.mcu.flash.set(fs.readFileSync(filesystem), FLASH_BYTES - FILESYSTEM_BYTES);

const encode = (bytes) => Buffer.from(bytes).toString('base64');
const taken = (list) => list.splice(0, list.length);

const requests = {
  run({ until, quantum, uart, console }) {
    if (uart) board.line.receive(Buffer.from(uart, 'base64'));
    if (console) board.console.waiting.push(...Buffer.from(console, 'base64'));
    const why = board.run(until, quantum ?? 0);
    return { why, uart: encode(taken(board.line.sent)), console: encode(taken(board.console.written)) };
  },
  reset({ cause }) {
    board.restart(cause);
    return {};
  },
  peek({ address, size }) {
    return { data: encode(board.mcu.sram.subarray(address - RAM, address - RAM + size)) };
  },
  poke({ address, data }) {
    board.mcu.sram.set(Buffer.from(data, 'base64'), address - RAM);
    return {};
  },
  peek_word({ address }) {
    return { value: board.mcu.readUint32(address) >>> 0 };
  },
  poke_word({ address, value }) {
    board.mcu.writeUint32(address, value);
    return {};
  },
  read_flash({ offset, size }) {
    return { data: encode(board.mcu.flash.subarray(offset, offset + size)) };
  },
  write_flash({ offset, data }) {
    board.mcu.flash.set(Buffer.from(data, 'base64'), offset);
    return {};
  },
  cut_power({ after }) {
    board.flash.cutAt = after ? board.flash.operations + after : 0;
    return {};
  },
  pin({ number, value }) {
    const pin = board.mcu.gpio[number];
    if (value !== undefined) pin.setInputValue(value);
    return { output: pin.outputValue, enabled: pin.outputEnable };
  },
  encoder({ bus, ...readings }) {
    Object.assign(board.encoders[bus], readings);
    return {};
  },
  pulse({ pin }) {
    const slice = board.mcu.pwm.channels[(pin >> 1) & 7];
    const level = pin & 1 ? slice.cc >>> 16 : slice.cc & 0xffff;
    return { ns: (level * slice.timer.prescaler * 1e9) / board.mcu.pwm.clockFreq };
  },
  measured() {
    return {
      collections: taken(board.collections), feeds: taken(board.feeds), resets: board.resets,
      stack: board.stackUsed(), flash_operations: board.flash.operations, uart_lost: board.line.lost,
      clock_hz: board.mcu.clkSys, flash_divider: board.mcu.peripherals[0x18000].baudr,
    };
  },
};

for await (const line of readline.createInterface({ input: process.stdin })) {
  const { request, ...settings } = JSON.parse(line);
  let answer;
  try {
    answer = requests[request](settings);
  } catch (error) {
    answer = { error: String(error) };
  }
  process.stdout.write(JSON.stringify({ ...answer, now: board.now() }) + '\n');
}
