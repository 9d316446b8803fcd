// A host at the end of the USB cable, as far as rp2040js has one: it enumerates the device, opens its serial port, and moves bytes.
import { USBCDC } from 'rp2040js';

/** Of rp2040js's buffer towards the board, which drops what does not fit. */
const ROOM = 512;

export class UsbCable {
  constructor(mcu, clock, onByte) {
    this.host = new USBCDC(mcu.usbCtrl);
    this.pending = [];
    this.isOpen = false;
    this.host.onDeviceConnected = () => {
      this.isOpen = true;
      this.go();
    };
    this.host.onSerialData = (bytes) => bytes.forEach(onByte);
    this.tick = clock.createAlarm(() => this.go());
  }

  send(bytes) {
    this.pending.push(...bytes);
    this.go();
  }

  /** Hands on what there is room for, and looks again after a frame of a millisecond. */
  go() {
    if (!this.isOpen) return;
    while (this.pending.length && this.host.txFIFO.itemCount < ROOM) this.host.sendSerialByte(this.pending.shift());
    if (this.pending.length) this.tick.schedule(1e6);
  }
}
