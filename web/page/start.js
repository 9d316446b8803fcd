"use strict";
// Unpacks the page's scripts and starts them. They stand in the page packed, so that one file is all there is; each becomes an
// address of its own here, under which the later ones import it.
(async () => {
  const inflate = async (node) => {
    const packed = Uint8Array.from(atob(node.textContent), (c) => c.charCodeAt(0));
    const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
    return new Uint8Array(await new Response(stream).arrayBuffer());
  };
  const address = (text) => URL.createObjectURL(new Blob([text], { type: "text/javascript" }));
  try {
    const addresses = new Map();
    for (const node of document.querySelectorAll("script[data-script]")) {
      const text = new TextDecoder().decode(await inflate(node));
      const linked = text.replace(/from\s*"\.\/([\w.-]+)"/g, (_, name) => `from "${addresses.get(name)}"`);
      addresses.set(node.dataset.script, address(linked));
    }
    const worker = document.querySelector("script[data-worker]");
    const part = async (name) => {
      const node = document.querySelector(`script[data-bytes="${name}"]`);
      return node ? inflate(node) : null;
    };
    const main = await import(addresses.get("main.js"));
    await main.start({
      mode: document.body.dataset.mode,
      worker: address(new TextDecoder().decode(await inflate(worker))),
      part,
    });
  } catch (error) {
    const at = document.getElementById("sentence");
    at.textContent = `This page could not start: ${error.message}. It needs a browser of 2023 or later.`;
    throw error;
  }
})();
