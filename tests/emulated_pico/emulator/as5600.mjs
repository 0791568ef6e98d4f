// An AS5600 magnetic encoder: the registers that show its magnet and the raw angle, and its address pointer, which
// stays at a raw angle that it was set to (data sheet, "Automatic Increment of the Address Pointer").

const ADDRESS = 0x36;
const STATUS = 0x0b;
const RAW_ANGLE = 0x0c; // high byte first

export class As5600 {
  constructor() {
    this.answers = false; // true for an encoder that is connected
    this.raw = 0; // 0 to 4095
    this.status = 0;
    this.pointer = 0;
    this.start = 0; // where the pointer was set to
    this.addressed = false; // a byte that is written next sets the pointer
  }

  connect(address, reads) {
    this.addressed = !reads;
    return this.answers && address === ADDRESS;
  }

  write(value) {
    if (this.addressed) this.pointer = this.start = value;
    this.addressed = false;
    return this.answers;
  }

  read() {
    if (!this.answers) return 0xff;
    const value = this.register(this.pointer);
    const stays = this.start === RAW_ANGLE && this.pointer === RAW_ANGLE + 1;
    this.pointer = stays ? RAW_ANGLE : (this.pointer + 1) & 0xff;
    return value;
  }

  register(address) {
    if (address === STATUS) return this.status;
    if (address === RAW_ANGLE) return this.raw >> 8;
    return address === RAW_ANGLE + 1 ? this.raw & 0xff : 0;
  }
}
