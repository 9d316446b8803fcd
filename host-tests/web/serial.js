// A stand-in for Web Serial: what the page writes goes to a TCP port where a board's console is, and back.
import { connect } from "node:net";

/** In the page, before its own scripts. */
export const STAND_IN = () => {
  let into = null;
  const waiting = [];
  window.serialCame = (text) => {
    if (into) into.enqueue(new TextEncoder().encode(text));
    else waiting.push(text);
  };
  window.serialGone = () => {
    const old = into;
    into = null;
    old?.error(new Error("the device has been lost"));
  };
  const port = {
    async open({ baudRate }) {
      if (!(await window.serialOpen(baudRate))) throw new Error("no such device");
      this.readable = new ReadableStream({
        start(controller) {
          into = controller;
          for (const text of waiting.splice(0)) controller.enqueue(new TextEncoder().encode(text));
        },
      });
      this.writable = new WritableStream({ write: (bytes) => window.serialSaid(new TextDecoder().decode(bytes)) });
    },
    async close() {
      into = null;
      await window.serialClosed();
    },
  };
  Object.defineProperty(navigator, "serial", { configurable: true, value: { requestPort: async () => port, addEventListener() {} } });
};

/** Joins the page's port and the board's. Gives a handle that pulls the cable and plugs it in again. */
export async function join(page, address) {
  const [host, port] = address.split(":");
  const cable = { in: true, socket: null, rates: [] };
  await page.exposeFunction("serialOpen", (rate) => new Promise((resolve) => {
    cable.rates.push(rate);
    if (!cable.in) {
      resolve(false);
      return;
    }
    const socket = connect(Number(port), host, () => resolve(true));
    socket.on("data", (bytes) => page.evaluate((text) => window.serialCame(text), bytes.toString("latin1")).catch(() => {}));
    socket.on("error", () => resolve(false));
    cable.socket = socket;
  }));
  await page.exposeFunction("serialSaid", (text) => { cable.socket?.write(text); });
  await page.exposeFunction("serialClosed", () => { cable.socket?.destroy(); });
  cable.pull = async () => {
    cable.in = false;
    cable.socket?.destroy();
    await page.evaluate(() => window.serialGone());
  };
  cable.plug = () => { cable.in = true; };
  return cable;
}
