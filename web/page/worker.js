"use strict";
// Runs the module. Questions and answers are JSON; the bytes of a log go with them.
let running = null;

const write = (slot, bytes) => {
  const at = running.reserve(slot, bytes.length);
  new Uint8Array(running.memory.buffer).set(bytes, at);
};

onmessage = async ({ data: { number, module, question, bytes } }) => {
  try {
    if (module) {
      running = (await WebAssembly.instantiate(module, {})).instance.exports;
      postMessage({ number, answer: "{}", ms: 0 });
      return;
    }
    const from = performance.now();
    write(0, new TextEncoder().encode(question));
    write(1, bytes ?? new Uint8Array());
    const length = running.ask();
    const said = new Uint8Array(running.memory.buffer, running.said(), length);
    postMessage({ number, answer: new TextDecoder().decode(said), ms: performance.now() - from });
  } catch (error) {
    // A module that has stopped in the middle is in no state to go on.
    postMessage({ number, error: `the analysis stopped (${error.message}); reload the page` });
  }
};
