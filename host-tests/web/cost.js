// node cost.js [RUNS]: what the page's module costs beside the program, in seconds of processor time (user and system, of all
// threads), so that other work on the machine hardly counts. Needs what `cargo ironout web -o DIR` builds, and bash for `times`.
import { spawnSync } from "node:child_process";
import { mkdtempSync, readFileSync, rmSync, statSync } from "node:fs";
import { tmpdir } from "node:os";
import { join } from "node:path";
import { fileURLToPath } from "node:url";
import { gzipSync } from "node:zlib";

const root = fileURLToPath(new URL("../../", import.meta.url));
const program = join(root, "target/host/ironout");
const module = readFileSync(join(root, "target/web-module/wasm32-unknown-unknown/web/ironout_wasm.wasm"));
const runs = Number(process.argv[2]) || 3;
const here = mkdtempSync(join(tmpdir(), "ironout-cost-"));
const LOGS = [["4 500 rows", "60", "75"], ["100 000 rows", "1000", "100"]];

/** Processor seconds of a command, of bash's `times`: its children's. */
function native(words) {
  const line = `${words.map((word) => `'${word}'`).join(" ")} > /dev/null 2> ${here}/said; echo $?; times`;
  const said = spawnSync("bash", ["-c", line], { encoding: "utf8" }).stdout.trim().split("\n");
  if (said[0] !== "0") throw new Error(`${words.join(" ")}: ${readFileSync(`${here}/said`, "utf8")}`);
  const seconds = (text) => { const [minutes, rest] = text.split("m"); return 60 * Number(minutes) + parseFloat(rest); };
  return said.at(-1).split(" ").reduce((sum, text) => sum + seconds(text), 0);
}

/** Processor seconds that this program spends meanwhile. */
async function own(work) {
  const from = process.cpuUsage();
  await work();
  const { user, system } = process.cpuUsage(from);
  return (user + system) * 1e-6;
}

/** As the page's worker asks. */
function ask(running, question, bytes = new Uint8Array()) {
  [new TextEncoder().encode(JSON.stringify(question)), bytes].forEach((part, slot) => {
    const at = running.reserve(slot, part.length);
    new Uint8Array(running.memory.buffer).set(part, at);
  });
  const length = running.ask();
  const answer = new TextDecoder().decode(new Uint8Array(running.memory.buffer, running.said(), length));
  const { error } = JSON.parse(answer);
  if (error) throw new Error(error.message);
}

/** What the first log and a further one cost the module, as JSON. */
async function moduleAlone(log) {
  const bytes = readFileSync(log);
  let running = null;
  const look = () => {
    ask(running, { do: "read", place: 0, options: { name: "log.csv" }, field_ut: null }, bytes);
    ask(running, { do: "look", place: 0, asked: { search: true, field_ut: null } });
  };
  const first = await own(async () => {
    running = (await WebAssembly.instantiate(module, {})).instance.exports;
    look();
  });
  console.log(JSON.stringify([first, await own(look)]));
}

const range = (all) => { const [least, most] = [Math.min(...all), Math.max(...all)].map((value) => value.toFixed(2)); return least === most ? least : `${least} to ${most}`; };
const over = (some, others) => `${(Math.min(...some) / Math.min(...others)).toFixed(2)} times`;

async function all() {
  console.log(`module ${(module.length / 1e6).toFixed(2)} MB, ${(gzipSync(module, { level: 9 }).length / 1e6).toFixed(2)} MB packed; n = ${runs}, seconds of processor time`);
  for (const [name, seconds, rate] of LOGS) {
    const log = join(here, "log.csv");
    native([program, "simulate", "-o", log, "--seed", "17", "--seconds", seconds, "--rate", rate, "--effect", "offset:current_a=3"]);
    const page = join(here, "report.html");
    const [reported, diagnosed, first, further] = [[], [], [], []];
    for (let run = 0; run < runs; run += 1) {
      reported.push(native([program, "report", log, "-o", page]));
      diagnosed.push(native([program, "diagnose", log]));
      // A program of its own each time: what is compiled while it runs counts in.
      const said = spawnSync(process.execPath, [fileURLToPath(import.meta.url), "--module", log], { encoding: "utf8" });
      if (said.status !== 0) throw new Error(said.stderr);
      const [begun, again] = JSON.parse(said.stdout);
      first.push(begun);
      further.push(again);
    }
    console.log(`${name}: report ${range(reported)} (${(statSync(page).size / 1e6).toFixed(1)} MB), diagnose ${range(diagnosed)}; module, first log ${range(first)} (${over(first, reported)}), further ones ${range(further)} (${over(further, reported)})`);
  }
}

try {
  if (process.argv[2] === "--module") await moduleAlone(process.argv[3]);
  else await all();
} finally {
  rmSync(here, { recursive: true, force: true });
}
