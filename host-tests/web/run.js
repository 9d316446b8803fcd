// node run.js SCENARIO '{"…": …}': runs one, and prints what it saw as one line of JSON.
import { alone, timed } from "./alone.js";
import { live, load, serial } from "./board.js";
import { hostile, report } from "./report.js";

const scenarios = { alone, hostile, live, load, report, serial, timed };
const [, , name, given] = process.argv;
const said = await scenarios[name](JSON.parse(given));
// What is still open (a cable, a stream) does not keep the program.
process.stdout.write(`${JSON.stringify(said)}\n`, () => process.exit(0));
