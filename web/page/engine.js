// The analysis, in a worker: questions go in turn, the page stays alive meanwhile.

export class Engine {
  /** Of the worker's address and a promise of the module's bytes. */
  constructor(address, module) {
    this.waiting = new Map();
    this.next = 1;
    this.ready = module.then((bytes) => {
      this.worker = new Worker(address);
      this.worker.onmessage = ({ data }) => this.answered(data);
      this.worker.onerror = (event) => this.failed(new Error(event.message || "the worker stopped"));
      return this.post({ module: bytes }, [bytes.buffer]);
    });
    this.ready.catch(() => {});
  }

  post(message, transfer) {
    const number = this.next++;
    return new Promise((resolve, reject) => {
      this.waiting.set(number, { resolve, reject });
      this.worker.postMessage({ ...message, number }, transfer);
    });
  }

  answered({ number, answer, error, ms }) {
    const { resolve, reject } = this.waiting.get(number);
    this.waiting.delete(number);
    if (error) reject(new Error(error));
    else resolve({ answer, ms });
  }

  failed(error) {
    for (const { reject } of this.waiting.values()) reject(error);
    this.waiting.clear();
  }

  /** Asks; an answer that is an error is thrown with its place. `bytes` are given away. */
  async ask(question, bytes = null) {
    await this.ready;
    const own = bytes ? new Uint8Array(bytes) : null;
    const { answer, ms } = await this.post({ question: JSON.stringify(question), bytes: own }, own ? [own.buffer] : []);
    const value = JSON.parse(answer);
    if (value.error) {
      const { file, line, column, message, question } = value.error;
      const place = [file && (line ? `${file}:${line}` : file), column && `column ${column}`].filter(Boolean).join(": ");
      throw Object.assign(new Error(place ? `${place}: ${message}` : message), { question });
    }
    this.took = ms;
    return value;
  }
}
