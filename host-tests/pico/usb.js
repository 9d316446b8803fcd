// A host at the end of the USB cable, as far as rp2040js has one: it enumerates the device, opens its serial port, and moves bytes.
import { USBCDC } from 'rp2040js';

const AVAILABLE = 1 << 10;
/** Buffer controls in the USB's memory: endpoint 0 IN at 0x80, OUT 4 bytes behind, 8 bytes an endpoint. */
const CONTROLS = 0x80;
const PACKET_BYTES = 64;
/** A bulk packet on the wire, with its handshake. */
const PACKET_NS = 60e3;

export class UsbCable {
  /** `pending`: bytes on their way to the board, which outlive a reset of it. */
  constructor(mcu, clock, pending, onByte) {
    const usb = mcu.usbCtrl;
    const host = new USBCDC(usb);
    Object.assign(this, { pending, isOpen: false, isArmed: false });
    host.onDeviceConnected = () => {
      this.isOpen = true;
      this.go();
    };
    host.onSerialData = (bytes) => bytes.forEach(onByte);

    // rp2040js gives the buffer of an OUT endpoint back at once, with nothing in it. A real host does not ask before it has
    // something to send, and the buffer is the chip's until then.
    const updated = usb.DPRAMUpdated.bind(usb);
    usb.DPRAMUpdated = (offset, value) => {
      const isData = this.isOpen && offset === CONTROLS + 8 * host.outEndpoint + 4;
      if (!isData || !(value & AVAILABLE)) return updated(offset, value);
      this.isArmed = true;
      this.go();
    };
    this.packet = clock.createAlarm(() => {
      const control = CONTROLS + 8 * host.outEndpoint + 4;
      this.isArmed = false;
      usb.finishRead(host.outEndpoint, Uint8Array.from(this.pending.splice(0, PACKET_BYTES)));
      mcu.usbDPRAMView.setUint32(control, mcu.usbDPRAMView.getUint32(control, true) & ~AVAILABLE, true);
    });
  }

  send(bytes) {
    this.pending.push(...bytes);
    this.go();
  }

  go() {
    if (this.isArmed && this.pending.length && !this.packet.isSet) this.packet.schedule(PACKET_NS);
  }
}
