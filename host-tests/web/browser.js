// One browser for one scenario: what the page says on its console, throws or asks of others is a failure.
import { chromium } from "playwright-core";
import { execFileSync } from "node:child_process";
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import axe from "axe-core";

/** Long enough for a busy machine: nothing here is timed. */
const PATIENCE_MS = Number(process.env.IRONOUT_PATIENCE_MS ?? 300000);

function program() {
  if (process.env.CHROMIUM) return process.env.CHROMIUM;
  for (const name of ["chromium", "chromium-browser", "google-chrome"]) {
    try {
      return execFileSync("which", [name], { encoding: "utf8" }).trim();
    } catch {
      // The next one.
    }
  }
  throw new Error("no chromium");
}

export class Browser {
  static async open({ shots = null, viewport = { width: 1200, height: 900 }, scheme = "light", init = null } = {}) {
    const own = new Browser();
    own.shots = shots;
    own.wrong = [];
    own.browser = await chromium.launch({
      executablePath: program(), headless: true, timeout: PATIENCE_MS,
      args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage"],
    });
    own.context = await own.browser.newContext({ viewport, colorScheme: scheme, reducedMotion: "reduce", acceptDownloads: true });
    if (init) await own.context.addInitScript(init);
    own.page = await own.context.newPage();
    own.page.setDefaultTimeout(PATIENCE_MS);
    own.page.on("console", (message) => {
      if (message.type() === "error") own.wrong.push(`console: ${message.text()}`);
    });
    own.page.on("pageerror", (error) => own.wrong.push(`thrown: ${error.message}`));
    own.page.on("dialog", (dialog) => {
      own.wrong.push(`a dialogue: ${dialog.message()}`);
      dialog.dismiss();
    });
    own.context.on("request", (request) => {
      const address = request.url();
      const here = ["file:", "blob:", "data:"].some((scheme) => address.startsWith(scheme)) || (own.origin && address.startsWith(own.origin));
      if (!here) own.wrong.push(`a request: ${address}`);
    });
    return own;
  }

  /** Opens the page and waits until it is ready. */
  async go(address) {
    if (address.startsWith("http")) this.origin = new URL(address).origin;
    await this.page.goto(address, { timeout: PATIENCE_MS });
    await this.page.waitForSelector("body[data-ready=true]", { timeout: PATIENCE_MS });
  }

  text(selector) {
    return this.page.locator(selector).first().innerText();
  }

  /** The text of something that may not be there. */
  maybe(selector) {
    return this.page.evaluate((at) => document.querySelector(at)?.textContent ?? null, selector);
  }

  /** Waits until the page itself says so. */
  until(what, argument) {
    return this.page.waitForFunction(what, argument, { timeout: PATIENCE_MS, polling: 100 });
  }

  /** Until a fit that was asked for is shown. */
  async settled() {
    await this.until(() => !document.body.dataset.busy);
  }

  async shot(name, options = {}) {
    if (!this.shots) return;
    mkdirSync(this.shots, { recursive: true });
    await this.page.screenshot({ path: join(this.shots, `${name}.png`), ...options });
  }

  /** What the rules of accessibility (WCAG 2 A and AA) object to. */
  async objections() {
    await this.page.evaluate(axe.source);
    const { violations } = await this.page.evaluate(() => window.axe.run(document, { runOnly: ["wcag2a", "wcag2aa"] }));
    return violations.map((one) => `${one.id}: ${one.nodes.slice(0, 3).map((node) => `${node.target} ${node.failureSummary}`).join(" | ")}`);
  }

  /** Whether the page is wider than its window, and what sticks out. */
  wide() {
    return this.page.evaluate(() => {
      const width = document.documentElement.clientWidth;
      if (document.documentElement.scrollWidth <= width) return [];
      return [...document.querySelectorAll("main *")].filter((one) => one.getBoundingClientRect().right > width + 1)
        .slice(0, 5).map((one) => `${one.tagName}.${one.className}#${one.id}`);
    });
  }

  async close() {
    await this.browser.close();
    return this.wrong;
  }
}

/** A microtesla in a text. */
export const number = (text) => Number(/-?[\d.]+/.exec(text)[0]);
