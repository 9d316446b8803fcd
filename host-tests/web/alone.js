// The page by itself: every format's sample is dropped on it, and a calibration file beside.
import { Browser, number } from "./browser.js";
import { probed } from "./report.js";
import { readFileSync } from "node:fs";
import { basename } from "node:path";
import { pathToFileURL } from "node:url";

/** Drops a file on the page, as a person does. */
async function drop(page, path) {
  const data = await page.evaluateHandle(([name, content]) => {
    const transfer = new DataTransfer();
    transfer.items.add(new File([Uint8Array.from(atob(content), (c) => c.charCodeAt(0))], name));
    return transfer;
  }, [basename(path), readFileSync(path).toString("base64")]);
  await page.dispatchEvent("#zone", "drop", { dataTransfer: data });
}

export async function alone({ file, samples, cal, unreadable, hostile, names, shots }) {
  const browser = await Browser.open({ shots });
  const { page } = browser;
  await browser.go(pathToFileURL(file).href);
  const said = { samples: [], empty: await browser.objections() };
  // The log that comes with the page, with a search: what is found is on.
  await page.locator("#example").click();
  await browser.until(() => document.body.dataset.log === "example.csv");
  await browser.settled();
  said.example = { name: await browser.text("#log-name"), sentence: await browser.text("#sentence"), on: await page.locator("[data-effect]:checked").evaluateAll((all) => all.map((one) => one.dataset.effect)) };
  // The samples are many, and the search is tested elsewhere.
  await page.locator("#reading-options, #raw-options").evaluateAll((all) => all.forEach((one) => { one.open = true; }));
  await page.locator("#search").uncheck();
  const read = async (options) => {
    for (const name of ["map", "ut_per_count", "instance"]) {
      await page.locator(`#option-${name}`).fill(options.filter(([own]) => own.replaceAll("-", "_") === name).map(([, value]) => value).join(";"));
    }
  };
  // A question of the reader is a form; nothing of the log before stands under the new name.
  const { path: asking, options: answers } = samples.at(-1);
  await drop(page, asking);
  await browser.until(() => document.getElementById("question"));
  said.question = { text: await browser.text("#question"), name: await browser.text("#log-name"), left: await page.evaluate(() => [...document.querySelectorAll("main section")].filter((one) => one.checkVisibility()).map((one) => one.id)) };
  said.question.objections = await browser.objections();
  await page.locator("#answer-scale").fill(answers.find(([own]) => own === "ut-per-count")[1]);
  await page.locator("#answer-read").click();
  await browser.until((name) => document.body.dataset.log === name, basename(asking));
  await browser.settled();
  said.question.answered = await browser.maybe("#error-now");
  for (const { path: sample, options } of samples) {
    await read(options);
    await drop(page, sample);
    await browser.until((name) => document.body.dataset.log === name || !document.getElementById("trouble").hidden, basename(sample));
    await browser.settled();
    const trouble = await page.locator("#trouble").textContent();
    const words = page.locator("#words-body details").filter({ has: page.locator("summary", { hasText: /^ironout fit/ }) });
    said.samples.push({
      name: basename(sample), trouble,
      words: trouble ? null : await words.locator("pre").textContent(),
      now: await browser.maybe("#error-now"),
      numbers: await browser.maybe("#numbers-body"),
    });
  }
  if (cal) {
    await drop(page, cal);
    await browser.until(() => !document.getElementById("beside").hidden || !document.getElementById("trouble").hidden);
    said.beside = await browser.text("#beside-body");
    // A log beside it: by the keyboard, and not in its place.
    await page.locator("#compare").focus();
    await page.keyboard.press("Space");
    const before = await page.evaluate(() => document.body.dataset.log);
    await read(samples[0].options);
    await drop(page, samples[0].path);
    await browser.until((name) => document.getElementById("beside-body").textContent.includes(name) || !document.getElementById("trouble").hidden, basename(samples[0].path));
    said.besideLog = await browser.text("#beside-body");
    said.stays = (await page.evaluate(() => document.body.dataset.log)) === before;
    await page.locator("#compare").uncheck();
  }
  await page.locator("#reading-options").evaluate((one) => { one.open = false; });
  await page.evaluate(() => window.scrollTo(0, 0));
  await browser.shot("alone");
  if (unreadable) {
    await drop(page, unreadable);
    await browser.until(() => !document.getElementById("trouble").hidden);
    said.refused = await page.locator("#trouble").textContent();
  }
  said.objections = await browser.usable();
  if (hostile) {
    await page.locator("#reading-options").evaluate((one) => { one.open = true; });
    await read([]);
    await drop(page, hostile);
    await browser.until((name) => document.body.dataset.log === name, basename(hostile));
    await browser.settled();
    said.hostile = await probed(page, names);
  }
  said.wrong = await browser.close();
  return said;
}

/** How long the module takes for a log: reading, and a fit with a search, in ms. */
export async function timed({ file, sample, runs }) {
  const browser = await Browser.open({});
  await browser.go(pathToFileURL(file).href);
  const times = [];
  for (let run = 0; run < runs; run += 1) {
    await browser.page.evaluate(() => { delete document.body.dataset.log; });
    await drop(browser.page, sample);
    await browser.until((name) => document.body.dataset.log === name, basename(sample));
    await browser.settled();
    times.push(Number(await browser.page.evaluate(() => document.body.dataset.took)));
  }
  return { times, wrong: await browser.close() };
}

export { number };
