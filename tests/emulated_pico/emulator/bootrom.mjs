// The boot ROM's functions for flash. The emulator has no flash chip to talk to, so those that erase and program are
// replaced by a breakpoint each, which flash.mjs serves, and those that only prepare the chip by a return.

const TABLE = 0x14; // holds the address of the table of functions
const RETURN = 0x4770; // bx lr
const BREAKPOINT = 0xbe00;
const PREPARE = ['IF', 'EX', 'FC', 'CX']; // connect flash, leave XIP, flush the cache, enter XIP
export const ERASE = 0xe1;
export const PROGRAM = 0xe2;

// Returns the `image` [bytes] of the ROM as words, with its flash functions replaced.
export function patched(image) {
  const words = new Uint32Array(image.buffer.slice(image.byteOffset, image.byteOffset + 16384));
  const view = new DataView(words.buffer);
  const functions = new Map();
  for (let at = view.getUint16(TABLE, true); view.getUint16(at, true); at += 4) {
    const name = String.fromCharCode(view.getUint8(at), view.getUint8(at + 1));
    functions.set(name, view.getUint16(at + 2, true) & ~1);
  }
  for (const name of PREPARE) view.setUint16(functions.get(name), RETURN, true);
  for (const [name, code] of [['RE', ERASE], ['RP', PROGRAM]]) {
    view.setUint16(functions.get(name), BREAKPOINT | code, true);
    view.setUint16(functions.get(name) + 2, RETURN, true);
  }
  return words;
}
