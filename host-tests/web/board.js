// A session with a board by clicks alone: from start to an accepted calibration and `why`; over the served page, or over the
// stand-in for Web Serial.
import { Browser } from "./browser.js";
import { connect } from "node:net";
import { join, STAND_IN } from "./serial.js";
import { readdirSync, readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

async function session(browser, said, shots, hidden = null) {
  const { page } = browser;
  const click = async (id) => {
    await page.locator(`#${id}:not([disabled])`).click();
    // The button's answer, not the one before it.
    await browser.until(() => document.getElementById("answer").textContent !== "…");
    return browser.text("#answer");
  };
  await browser.until(() => document.getElementById("link").dataset.state === "open");
  said.link = await browser.text("#link");
  said.started = await click("cal-start");
  await browser.until(() => document.body.dataset.board === "collecting");
  await browser.until(() => document.getElementById("hint").textContent.includes("side"));
  said.hint = await browser.text("#hint");
  // The same as a figure: by how many degrees to turn.
  await browser.until(() => document.getElementById("turning").checkVisibility());
  said.turning = Number(await page.locator("#turning").getAttribute("data-angle"));
  await browser.until(() => document.getElementById("hint").textContent.includes("enough directions"));
  said.turned = !(await page.locator("#turning").isVisible());
  said.coverage = await browser.text("#value-coverage");
  await browser.shot(`${shots}-collecting`, { fullPage: true });
  said.stopped = await click("cal-stop");
  said.judged = await browser.text("#judged");
  said.accepted = await click("cal-accept");
  await browser.until(() => document.body.dataset.calibrated === "1");
  await browser.until(() => /\d/.test(document.getElementById("now-error").textContent));
  said.reading = (await browser.text("#now-magnitude")).replace(/\s+/g, " ");
  await asked(browser, said, hidden ? "missing" : "complete");
  if (hidden) await learned(browser, said, hidden);
  // What is not seen is not drawn.
  await page.locator("#plot-live").scrollIntoViewIfNeeded();
  await browser.until(() => Number(document.getElementById("plot-live").dataset.drawn) > 5);
  await browser.shot(`${shots}-calibrated`, { fullPage: true });
  // What was recorded meanwhile, as a log of its own.
  const download = await browser.downloaded(page.locator("#save-log"));
  said.recording = download.suggestedFilename();
  said.log = await (await import("node:fs/promises")).readFile(await download.path(), "utf8");
  await page.locator("#look-log").click();
  await browser.until(() => document.body.dataset.log || !document.getElementById("busy").textContent.includes("…"));
  await browser.settled();
  said.advice = await browser.text("#advice");
  said.now = await browser.text("#error-now");
  said.objections = await browser.objections();
}

/** How many of the board's lines have come. */
const lines = (browser) => browser.page.evaluate(() => Number(document.body.dataset.samples));

/** Until so many more have come. */
async function more(browser, count) {
  await browser.until((most) => Number(document.body.dataset.samples) > most, (await lines(browser)) + count);
}

/** Asks why, as often as it takes: it learns from the samples of its calibration, and there have to be enough of them. */
async function asked(browser, said, wanted) {
  for (let round = 0; round < 12; round += 1) {
    await clicked(browser, "#ask-why");
    said.whyAnswer = await browser.text("#answer");
    said.verdict = await browser.page.locator("#why").getAttribute("data-verdict");
    if (said.verdict === wanted) break;
    await more(browser, 400);
  }
  said.why = await browser.text("#why");
}

/** The error of the last seconds, µT. */
const rms = async (browser) => Number(/[\d.]+(?= µT)/.exec(await browser.text("#now-rms strong"))?.[0]);

/** Until the error of the last seconds is so large: what is hidden comes and goes. */
const off = (browser, least) => browser.until((ut) => parseFloat(document.querySelector("#now-rms strong").textContent) > ut, least);

/** What `why` names is added by a click, and the error falls; it is removed by another, and the error is back. */
async function learned(browser, said, { id, noise_ut: noise, use = clicked }) {
  const choice = `[data-effect-id="${id}"]`;
  if (said.calibrated !== false) {
    await off(browser, 2.6 * noise);
    said.errorBefore = await rms(browser);
  }
  for (let round = 0; round < 12; round += 1) {
    await use(browser, `${choice}:text("add")`);
    said.added = await browser.text("#answer");
    if (said.added.startsWith("done")) break;
    // It is seen, and unseen samples do not bear it out yet.
    await more(browser, 400);
  }
  await browser.until(() => /\d/.test(document.querySelector("#now-rms strong").textContent));
  await more(browser, 600);
  said.errorLearned = await rms(browser);
  said.whyLearned = await browser.text("#why");
  await browser.shot("learned", { fullPage: true });
  await use(browser, `${choice}:text("remove")`);
  said.removed = await browser.text("#answer");
  await off(browser, 2 * said.errorLearned);
  said.errorRemoved = await rms(browser);
}

/** The page that `ironout live` serves. */
export async function live({ address, hidden, shots }) {
  const browser = await Browser.open({ shots });
  const said = {};
  await browser.go(address);
  await session(browser, said, "live", hidden);
  said.wrong = await browser.close();
  return said;
}

/** The page by itself, over a serial port; the cable is pulled in between. */
export async function serial({ file, address, shots }) {
  const browser = await Browser.open({ shots, init: STAND_IN });
  const said = {};
  const cable = await join(browser.page, address);
  await browser.go(pathToFileURL(file).href);
  await browser.page.locator("#connect").click();
  await browser.until(() => document.getElementById("link").dataset.state === "open");
  await cable.pull();
  await browser.until(() => document.getElementById("link").dataset.state === "gone");
  said.gone = await browser.text("#link");
  cable.plug();
  await session(browser, said, "serial");
  said.rates = cable.rates;
  said.wrong = await browser.close();
  cable.socket?.destroy();
  return said;
}

/** Clicks, and waits for the answer to that click. */
async function clicked(browser, selector) {
  await browser.page.locator(`${selector}:not([disabled])`).click();
  await browser.until(() => document.getElementById("answer").textContent !== "…");
}

/** The same by the keyboard. */
async function pressed(browser, selector) {
  await browser.page.locator(`${selector}:not([disabled])`).focus();
  await browser.page.keyboard.press("Enter");
  await browser.until(() => document.getElementById("answer").textContent !== "…");
}

/** A log that is replayed, by the keyboard alone: its calibration is refused, `why` says what is missing, and with that it is one. */
export async function replay({ address, hidden, shots }) {
  const browser = await Browser.open({ shots });
  const said = { calibrated: false };
  await browser.go(address);
  await link(browser, "open");
  said.idle = await browser.page.locator("#ask-why").isDisabled();
  await pressed(browser, "#cal-start");
  said.held = await browser.page.evaluate(() => document.activeElement.id);
  await browser.until(() => parseInt(document.getElementById("value-coverage").textContent, 10) > 90);
  said.objections = await browser.usable();
  await pressed(browser, "#cal-stop");
  said.judged = await browser.text("#judged");
  await browser.until(() => document.body.dataset.board === "refused");
  // It goes on learning.
  await more(browser, 3000);
  for (let round = 0; round < 12; round += 1) {
    await pressed(browser, "#ask-why");
    said.verdict = await browser.page.locator("#why").getAttribute("data-verdict");
    if (said.verdict === "missing") break;
    await more(browser, 400);
  }
  said.why = await browser.text("#why");
  await browser.shot("refused", { fullPage: true });
  await learned(browser, said, { ...hidden, use: pressed });
  await browser.until(() => document.body.dataset.calibrated === "1");
  // The refusal is answered with it.
  await browser.until(() => document.body.dataset.board === "idle");
  said.hint = await browser.text("#hint");
  await browser.page.locator("#plot-live").scrollIntoViewIfNeeded();
  await browser.until(() => Number(document.getElementById("plot-live").dataset.drawn) > 5);
  said.objections.push(...await browser.usable());
  await browser.shot("replay", { fullPage: true });
  said.wrong = await browser.close();
  return said;
}

/** A download that a click begins: its name and its text. */
async function downloaded(browser, selector) {
  const download = await browser.downloaded(browser.page.locator(selector));
  return [download.suggestedFilename(), readFileSync(await download.path(), "utf8")];
}

/** Until the way to the board is in this state: what the page says of it. */
async function link(browser, state) {
  await browser.until((wanted) => document.getElementById("link").dataset.state === wanted, state);
  return browser.text("#link");
}

/** A board that hangs, behind a cable that is pulled; `hands` is where its hands are. */
export async function cable({ address, hands, shots }) {
  const browser = await Browser.open({ shots });
  const said = {};
  const [host, port] = hands.split(":");
  const hand = connect(Number(port), host);
  await browser.go(address);
  await link(browser, "open");
  // It hangs: nothing comes, and the page says so.
  hand.write("deaf\n");
  said.silent = await link(browser, "silent");
  hand.write("hear\n");
  await link(browser, "open");
  // The cable is pulled, and plugged in again.
  hand.write("pull\n");
  said.gone = await link(browser, "gone");
  hand.write("plug\n");
  said.back = await link(browser, "open");
  // It goes on: what is asked is answered.
  await clicked(browser, "#cal-start");
  said.started = await browser.text("#answer");
  said.wrong = await browser.close();
  hand.destroy();
  return said;
}

/** The page by itself on a serial port, with a sketch at its end that prints `Raw:` lines; then with a hostile board. */
export async function sketch({ file, address, rows, hostile, name, shots }) {
  const said = {};
  const browser = await Browser.open({ shots, init: STAND_IN });
  const { page } = browser;
  await join(page, address);
  await browser.go(pathToFileURL(file).href);
  await page.locator("#connect").click();
  said.link = await link(browser, "open");
  await browser.until((most) => Number(document.body.dataset.samples) > most, rows);
  await browser.shot("sketch", { fullPage: true });
  [said.recording, said.log] = await downloaded(browser, "#save-log");
  // What is looked at is what was saved: the rest of the stream is not in it.
  await page.locator("#file").setInputFiles({ name: "recording.txt", mimeType: "text/plain", buffer: Buffer.from(said.log) });
  await browser.until(() => document.body.dataset.log === "recording.txt");
  await browser.settled();
  said.words = await page.locator("#words-body details").filter({ has: page.locator("summary", { hasText: /^ironout fit/ }) }).locator("pre").textContent();
  await page.evaluate(() => { delete document.body.dataset.log; });
  await page.locator("#look-log").click();
  await browser.until(() => document.body.dataset.log === "recording.txt");
  await browser.settled();
  said.advice = await browser.text("#advice");
  said.wrong = await browser.close();

  const other = await Browser.open({ init: STAND_IN });
  await join(other.page, hostile);
  await other.go(pathToFileURL(file).href);
  await other.page.locator("#connect").click();
  said.hostileLink = await link(other, "open");
  await other.until((text) => document.getElementById("hint").textContent.includes(text), name);
  said.hostileHint = await other.text("#hint");
  await clicked(other, "#ask-why");
  said.hostileWhy = await other.text("#why");
  await clicked(other, "#cal-start");
  await other.until(() => Number(document.body.dataset.samples) > 60 && !document.getElementById("save-log").disabled);
  said.hostileSaved = (await downloaded(other, "#save-log"))[1];
  await other.page.locator("details").evaluateAll((all) => all.forEach((one) => { one.open = true; }));
  said.injected = await other.page.evaluate(() => [...document.querySelectorAll("img, iframe, b:not([id]), object, embed")].map((one) => one.outerHTML));
  said.marked = await other.page.evaluate(() => Boolean(window.injected));
  said.wrong.push(...await other.close());
  return said;
}

/** Seconds of a processor that each kind of Chromium's processes has had (Linux): `renderer` runs the page, `gpu-process` draws. */
function processorSeconds(root) {
  const all = readdirSync("/proc").filter((name) => /^\d+$/.test(name)).flatMap((name) => {
    try {
      const cells = readFileSync(`/proc/${name}/stat`, "utf8").replace(/^.*\) /s, "").split(" ");
      const kind = /--type=([a-z-]+)/.exec(readFileSync(`/proc/${name}/cmdline`, "utf8"))?.[1] ?? "browser";
      return [{ pid: Number(name), parent: Number(cells[1]), kind, seconds: (Number(cells[11]) + Number(cells[12])) / 100 }];
    } catch {
      return [];
    }
  });
  const sums = {};
  const add = (parent) => all.filter((one) => one.parent === parent).forEach((one) => {
    sums[one.kind] = (sums[one.kind] ?? 0) + one.seconds;
    add(one.pid);
  });
  add(root);
  return sums;
}

/**
 * What the page does while a board streams, collecting and calibrated: samples, updates, layouts, passes over styles and new nodes
 * a second; and shares of a core by process and, of the page's main thread, by what it does.
 */
export async function load({ address, seconds, server }) {
  const browser = await Browser.open({ processorDraws: true });
  const { page } = browser;
  await browser.go(address);
  await link(browser, "open");
  const tools = await browser.context.newCDPSession(page);
  await tools.send("Performance.enable", { timeDomain: "threadTicks" });
  const own = () => {
    const cells = readFileSync(`/proc/${server}/stat`, "utf8").replace(/^.*\) /s, "").split(" ");
    return (Number(cells[11]) + Number(cells[12])) / 100;
  };
  const measure = async () => {
    const { metrics } = await tools.send("Performance.getMetrics");
    const main = Object.fromEntries(metrics.filter(({ name }) => /^(Task|Script|Layout|RecalcStyle)Duration$|^(LayoutCount|RecalcStyleCount|Nodes)$/.test(name)).map(({ name, value }) => [name, value]));
    const counts = await page.evaluate(() => ({ samples: Number(document.body.dataset.samples), updates: Number(document.body.dataset.drawn) }));
    return { at: performance.now() / 1000, ...counts, ...main, ...processorSeconds(process.pid), server: own() };
  };
  const rates = async () => {
    const first = await measure();
    await page.waitForTimeout(1000 * seconds);
    const last = await measure();
    return Object.fromEntries(Object.keys(last).filter((key) => key !== "at").map((key) => [key, Number(((last[key] - (first[key] ?? 0)) / (last.at - first.at)).toFixed(4))]));
  };
  const said = {};
  await clicked(browser, "#cal-start");
  await browser.until(() => document.getElementById("hint").textContent.includes("enough directions"));
  said.collecting = await rates();
  await clicked(browser, "#cal-stop");
  await clicked(browser, "#cal-accept");
  await browser.until(() => /\d/.test(document.getElementById("now-rms").textContent));
  await page.locator("#plot-live").scrollIntoViewIfNeeded();
  said.calibrated = await rates();
  said.wrong = await browser.close();
  return said;
}
