// A session with a board by clicks alone: from start to an accepted calibration and `why`; over the served page, or over the
// stand-in for Web Serial.
import { Browser } from "./browser.js";
import { join, STAND_IN } from "./serial.js";
import { readdirSync, readFileSync } from "node:fs";
import { pathToFileURL } from "node:url";

async function session(browser, said, shots) {
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
  await browser.until(() => document.getElementById("hint").textContent);
  said.hint = await browser.text("#hint");
  await browser.until(() => document.getElementById("hint").textContent.includes("enough directions"));
  said.coverage = await browser.text("#value-coverage");
  await browser.shot(`${shots}-collecting`, { fullPage: true });
  said.stopped = await click("cal-stop");
  said.judged = await browser.text("#judged");
  said.accepted = await click("cal-accept");
  await browser.until(() => document.body.dataset.calibrated === "1");
  await browser.until(() => document.getElementById("reading").textContent.includes("magnitude"));
  said.reading = await browser.text("#reading");
  // It learns from the samples of its calibration: asked again until there were enough of them.
  for (let asked = 0; asked < 12; asked += 1) {
    said.whyAnswer = await click("ask-why");
    said.verdict = await browser.page.locator("#why").getAttribute("data-verdict");
    if (said.verdict !== "undetermined") break;
    await browser.until((before) => Number(document.body.dataset.samples) > before + 400, Number(await page.evaluate(() => document.body.dataset.samples)));
  }
  said.why = await browser.text("#why");
  await browser.until(() => Number(document.getElementById("plot-live").dataset.drawn) > 30);
  await browser.shot(`${shots}-calibrated`, { fullPage: true });
  // What was recorded meanwhile, as a log of its own.
  const [download] = await Promise.all([page.waitForEvent("download"), page.locator("#save-log").click()]);
  said.recording = download.suggestedFilename();
  said.log = await (await import("node:fs/promises")).readFile(await download.path(), "utf8");
  await page.locator("#look-log").click();
  await browser.until(() => document.body.dataset.log || !document.getElementById("busy").textContent.includes("…"));
  await browser.settled();
  said.sentence = await browser.text("#sentence");
  said.now = await browser.text("#error-now");
  said.objections = await browser.objections();
}

/** The page that `ironout live` serves. */
export async function live({ address, shots }) {
  const browser = await Browser.open({ shots });
  const said = {};
  await browser.go(address);
  await session(browser, said, "live");
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

/** Seconds that all processes begun by this one have had a processor (Linux). */
function processorSeconds(root) {
  const all = readdirSync("/proc").filter((name) => /^\d+$/.test(name)).flatMap((name) => {
    try {
      const cells = readFileSync(`/proc/${name}/stat`, "utf8").replace(/^.*\) /s, "").split(" ");
      return [{ pid: Number(name), parent: Number(cells[1]), seconds: (Number(cells[11]) + Number(cells[12])) / 100 }];
    } catch {
      return [];
    }
  });
  const below = (pid) => all.filter((one) => one.parent === pid).reduce((sum, one) => sum + one.seconds + below(one.pid), 0);
  return below(root);
}

/** How much of one core the page takes while a board streams: {updates a second, share of a core}. */
export async function load({ address, seconds }) {
  const browser = await Browser.open({});
  await browser.go(address);
  await browser.until(() => document.getElementById("link").dataset.state === "open");
  await browser.until(() => Number(document.body.dataset.samples) > 100);
  const measure = async () => ({ at: performance.now() / 1000, busy: processorSeconds(process.pid), samples: Number(await browser.page.evaluate(() => document.body.dataset.samples)), drawn: Number(await browser.page.evaluate(() => document.body.dataset.drawn)) });
  const first = await measure();
  await browser.page.waitForTimeout(1000 * seconds);
  const last = await measure();
  const time = last.at - first.at;
  return { samples: (last.samples - first.samples) / time, updates: (last.drawn - first.drawn) / time, share: (last.busy - first.busy) / time, wrong: await browser.close() };
}
