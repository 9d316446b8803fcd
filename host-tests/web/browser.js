// One browser for one scenario: what the page says on its console, throws or asks of others is a failure.
import { chromium } from "playwright-core";
import { execFileSync } from "node:child_process";
import { mkdirSync } from "node:fs";
import { join } from "node:path";
import axe from "axe-core";

/** Long enough for a busy machine: nothing here is timed. Less than the limit of a test, so that what was waited for is said. */
const PATIENCE_MS = Number(process.env.IRONOUT_PATIENCE_MS ?? 120000);

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
  /** `processorDraws`: as where there is no graphics processor; a test's graphics processor is imitated by the processor. */
  static async open({ shots = null, viewport = { width: 1200, height: 900 }, scheme = "light", init = null, processorDraws = false } = {}) {
    const own = new Browser();
    own.shots = shots;
    own.wrong = [];
    own.browser = await chromium.launch({
      executablePath: program(), headless: true, timeout: PATIENCE_MS,
      args: ["--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader", "--disable-dev-shm-usage", ...(processorDraws ? ["--disable-gpu-compositing"] : [])],
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

  /** The file that a button gives. Chromium drops the eleventh of downloads in quick succession: then once more, as a person would. */
  async downloaded(button) {
    const once = async (timeout) => (await Promise.all([this.page.waitForEvent("download", { timeout }), button.click()]))[0];
    return once(PATIENCE_MS / 4).catch(() => once(PATIENCE_MS / 2));
  }

  /** Until a fit that was asked for is shown. */
  async settled() {
    await this.until(() => !document.body.dataset.busy);
  }

  async shot(name, options = {}) {
    if (!this.shots) return;
    mkdirSync(this.shots, { recursive: true });
    // What sticks to the top of a window stands at the top of the whole page.
    if (options.fullPage) await this.page.evaluate(() => window.scrollTo(0, 0));
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

  /** What the keyboard does not reach by Tab, of all that can be seen and used. */
  async unreached() {
    await this.page.evaluate(() => {
      document.activeElement?.blur();
      window.scrollTo(0, 0);
      const all = [...document.querySelectorAll("a[href], button, input, select, summary, textarea, [tabindex='0']")];
      window.wanted = new Set(all.filter((one) => !one.disabled && one.checkVisibility()));
    });
    const count = await this.page.evaluate(() => window.wanted.size);
    for (let pressed = 0; pressed < count + 10; pressed += 1) {
      await this.page.keyboard.press("Tab");
      if ((await this.page.evaluate(() => (window.wanted.delete(document.activeElement), window.wanted.size))) === 0) break;
    }
    return this.page.evaluate(() => [...window.wanted].map((one) => `${one.tagName}#${one.id} ${one.textContent.slice(0, 40)}`));
  }

  /** Plots that say nothing to those who do not see them: no name, or no table of their numbers. */
  mute() {
    return this.page.evaluate(async () => {
      const wrong = [];
      for (const one of document.querySelectorAll(".uplot")) {
        const plot = one.closest("[role=img]");
        if (!plot?.checkVisibility()) continue;
        if (!plot.getAttribute("aria-label")) wrong.push(`${plot.id}: no name`);
        const numbers = plot.closest("figure").querySelector("details");
        if (!numbers) {
          wrong.push(`${plot.id}: no numbers`);
          continue;
        }
        numbers.open = true;
        await new Promise((resolve) => { setTimeout(resolve); });
        const table = numbers.querySelector("table");
        if (!table?.caption?.textContent || table.querySelectorAll("tbody td").length < 2) wrong.push(`${plot.id}: an empty table`);
        numbers.open = false;
      }
      return wrong;
    });
  }

  /** All that is asked of a page whatever it shows: rules, keys, words for plots, dark, a telephone's width. Objections. */
  async usable() {
    const { page } = this;
    const wrong = [...await this.objections(), ...(await this.unreached()).map((one) => `no key leads to ${one}`), ...await this.mute()];
    const theme = () => page.evaluate(() => document.documentElement.dataset.theme);
    const before = await theme();
    await page.locator("#theme").click();
    if ((await theme()) === before) wrong.push("the theme does not change");
    wrong.push(...(await this.objections()).map((one) => `not in ${before}: ${one}`));
    await page.locator("#theme").click();
    const size = page.viewportSize();
    await page.setViewportSize({ width: 360, height: 740 });
    await this.until(() => [...document.querySelectorAll(".uplot")].filter((one) => one.checkVisibility()).every((one) => one.clientWidth <= 360));
    wrong.push(...(await this.wide()).map((one) => `wider than a telephone: ${one}`));
    await page.setViewportSize(size);
    return wrong;
  }

  async close() {
    await this.browser.close();
    return this.wrong;
  }
}

/** A microtesla in a text. */
export const number = (text) => Number(/-?[\d.]+/.exec(text)[0]);
