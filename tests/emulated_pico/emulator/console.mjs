// The board's USB serial port: what a computer on the cable sends and reads.

import { USBCDC } from 'rp2040js';

const ROOM = 400; // bytes that are handed to the emulated USB device at once

export class Console {
  constructor(usb) {
    this.written = []; // by the board
    this.waiting = []; // for the board
    this.cdc = new USBCDC(usb);
    this.cdc.onSerialData = (bytes) => this.written.push(...bytes);
    this.refused = null; // a read of the board's that found nothing
    this.serveRead = usb.onEndpointRead;
    usb.onEndpointRead = (endpoint, size) => {
      if (endpoint !== 0 && endpoint === this.cdc.outEndpoint && this.cdc.txFIFO.empty) this.refused = [endpoint, size];
      else this.serveRead(endpoint, size);
    };
  }

  // Pass on what there is room for.
  pump() {
    while (this.waiting.length && this.cdc.txFIFO.itemCount < ROOM) {
      this.cdc.sendSerialByte(this.waiting.shift());
      if (this.refused) {
        const read = this.refused;
        this.refused = null;
        this.serveRead(...read);
      }
    }
  }
}
