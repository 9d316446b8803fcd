// A report: the sphere turned, the missing effect switched on, paper, phone, light and dark.
import { Browser, number } from "./browser.js";
import { pathToFileURL } from "node:url";

export async function report({ file, effect, shots }) {
  const said = {};
  const browser = await Browser.open({ shots });
  const { page } = browser;
  await browser.go(pathToFileURL(file).href);
  said.title = await page.title();
  said.sentence = await browser.text("#sentence");
  said.before = number(await browser.text("#error-before"));
  said.base = number(await browser.text("#error-base"));
  said.found = number(await browser.text("#error-now"));
  said.floor = number(await browser.text("#floor"));
  // The picture is drawn, and turns by mouse and by key.
  const view = () => page.locator("#sphere").getAttribute("data-view");
  await browser.until(() => document.getElementById("sphere").dataset.view);
  const first = await view();
  await page.locator("#sphere").scrollIntoViewIfNeeded();
  const box = await page.locator("#sphere").boundingBox();
  await page.mouse.move(box.x + box.width / 2, box.y + box.height / 2);
  await page.mouse.down();
  await page.mouse.move(box.x + box.width / 2 + 120, box.y + box.height / 2 + 30, { steps: 4 });
  await page.mouse.up();
  await browser.until((before) => document.getElementById("sphere").dataset.view !== before, first);
  const second = await view();
  await page.locator("#sphere").focus();
  await page.keyboard.press("ArrowRight");
  await browser.until((before) => document.getElementById("sphere").dataset.view !== before, second);
  said.turned = true;
  await page.evaluate(() => window.scrollTo(0, 0));
  await browser.shot("report-top");
  // The missing effect is on; by the keyboard alone it is switched off and on again.
  const drawn = () => page.locator("#plot-column").getAttribute("data-drawn");
  const before = await drawn();
  said.on = await page.locator(`[data-effect="${effect}"]`).isChecked();
  await page.locator(`[data-effect="${effect}"]`).focus();
  await page.keyboard.press("Space");
  await browser.until((value) => document.getElementById("error-now").textContent.startsWith(value), said.base.toFixed(3));
  await browser.settled();
  said.sentenceOff = await browser.text("#sentence");
  await page.keyboard.press("Space");
  await browser.until((old) => !document.body.dataset.busy && (document.getElementById("plot-column").dataset.drawn !== old || document.getElementById("busy").textContent), before);
  said.now = number(await browser.text("#error-now"));
  said.floorNow = number(await browser.text("#floor"));
  said.sentenceNow = await browser.text("#sentence");
  said.steps = await page.locator("[data-step]").allInnerTexts();
  said.checked = await page.locator(`[data-effect="${effect}"]`).isChecked();
  said.busy = await page.locator("#busy").textContent();
  await page.locator("#falling").scrollIntoViewIfNeeded();
  await browser.shot("report-switched", { fullPage: true });
  // A calibration for a target, as a download.
  const download = await browser.downloaded(page.locator("[data-form=c]"));
  said.download = download.suggestedFilename();
  said.exported = await browser.text("#exported");
  // Every target has its button, and each gives a file.
  await page.locator("#scale").fill("0.15");
  said.targets = {};
  for (const form of await page.locator("[data-form]:is(button)").evaluateAll((all) => all.map((one) => one.dataset.form))) {
    const file = await browser.downloaded(page.locator(`button[data-form=${form}]`));
    said.targets[form] = [file.suggestedFilename(), await browser.text("#exported")];
  }
  // Each figure as SVG.
  said.figures = {};
  for (const name of ["residual", "dots", "spectrum", "histogram", "directions"]) {
    const file = await browser.downloaded(page.locator(`[data-svg="${name}"]`));
    const text = await (await import("node:fs/promises")).readFile(await file.path(), "utf8");
    const drawn = await page.evaluate((svg) => {
      const root = new DOMParser().parseFromString(svg, "image/svg+xml").documentElement;
      return { root: root.nodeName, marks: root.querySelectorAll("path, circle").length, words: root.textContent };
    }, text);
    said.figures[file.suggestedFilename()] = { ...drawn, broken: /NaN|undefined|Infinity/.test(text) };
  }
  // What else it says of the effect and of the log.
  said.numbers = await browser.text("#numbers-body");
  said.open = await browser.text("#open-body");
  said.choices = await page.locator("#column option").allInnerTexts();
  said.plots = await page.evaluate(() => [...document.querySelectorAll(".plot[id]")].filter((one) => one.checkVisibility() && one.dataset.drawn).map((one) => one.id));
  said.gaps = await browser.text("#ball-body");
  await page.locator("footer summary").click();
  said.licences = await browser.text("footer pre");
  said.objections = await browser.usable();
  // Dark.
  await page.locator("#theme").click();
  said.dark = await page.evaluate(() => document.documentElement.dataset.theme);
  await page.evaluate(() => window.scrollTo(0, 0));
  await browser.shot("report-dark");
  // Off again.
  await page.locator(`[data-effect="${effect}"]`).click();
  await browser.until((value) => document.getElementById("error-now").textContent.startsWith(value), said.base.toFixed(3));
  await browser.settled();
  said.sentenceAgain = await browser.text("#sentence");
  // A telephone.
  await page.setViewportSize({ width: 390, height: 844 });
  await browser.until(() => [...document.querySelectorAll(".uplot")].every((one) => one.clientWidth <= 390));
  said.wide = await browser.wide();
  await browser.shot("report-phone");
  // Paper: white, without what can only be clicked.
  await page.emulateMedia({ media: "print" });
  await page.evaluate(() => window.dispatchEvent(new Event("beforeprint")));
  said.onPaper = await page.evaluate(() => [...document.querySelectorAll("header, .buttons, #export, #words, .uplot, #sentence, #figures, #stairs, .for-print > svg")].filter((one) => one.checkVisibility()).map((one) => one.id || one.getAttribute("aria-label") || one.tagName));
  await browser.shot("report-paper", { fullPage: true });
  await page.evaluate(() => window.dispatchEvent(new Event("afterprint")));
  await page.emulateMedia({ media: null });
  const pdf = await page.pdf({ format: "A4" });
  said.pages = pdf.toString("latin1").match(/\/Type\s*\/Page[^s]/g)?.length ?? 0;
  said.wrong = await browser.close();
  return said;
}

/** A report with others beside it: the heads of its table and the rows, and what is said of faults. */
export async function beside({ file, shots }) {
  const browser = await Browser.open({ shots });
  const { page } = browser;
  await browser.go(pathToFileURL(file).href);
  const rows = page.locator("#beside-body table").first().locator("tr");
  const said = { rows: await rows.evaluateAll((all) => all.map((row) => [...row.cells].map((cell) => cell.textContent))) };
  said.legends = await page.locator("#plot-beside-histogram .u-legend .u-label").allInnerTexts();
  said.links = await page.locator("#parts a").allInnerTexts();
  said.faults = await browser.text("#faults");
  // A span in another colour stands in the plot where the fault is.
  said.shaded = await page.evaluate(() => document.getElementById("plot-residual").plot.given.marks);
  await page.locator("#beside").scrollIntoViewIfNeeded();
  await browser.shot("beside");
  said.objections = await browser.usable();
  said.wrong = await browser.close();
  return said;
}

/** A report of a log with hostile names: nothing of it becomes markup, and all of it is text. */
export async function hostile({ file, names }) {
  const browser = await Browser.open({});
  const { page } = browser;
  await browser.go(pathToFileURL(file).href);
  const said = await probed(page, names);
  said.wrong = await browser.close();
  return said;
}

/** Opens all there is of a log with hostile names: what has become markup, and what of them is text. */
export async function probed(page, names) {
  const said = { columns: await page.locator("#column option").allInnerTexts() };
  for (const name of said.columns) {
    await page.locator("#column").selectOption({ label: name });
  }
  await page.locator("details").evaluateAll((all) => all.forEach((one) => { one.open = true; }));
  said.injected = await page.evaluate(() => [...document.querySelectorAll("img, iframe, b:not([id]), object, embed")].map((one) => one.outerHTML));
  said.marked = await page.evaluate(() => Boolean(window.injected));
  said.seen = await page.evaluate((all) => all.filter((name) => document.body.textContent.includes(name)), names);
  return said;
}
