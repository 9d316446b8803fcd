// node run.js SCENARIO '{"…": …}': runs one, and prints what it saw as one line of JSON.
import { alone, timed } from "./alone.js";
import { live, load, cable, serial, sketch } from "./board.js";
import { beside, hostile, report } from "./report.js";

const scenarios = { alone, beside, cable, hostile, live, load, report, serial, sketch, timed };
const [, , name, given] = process.argv;
const said = await scenarios[name](JSON.parse(given));
// What is still open (a cable, a stream) does not keep the program.
process.stdout.write(`${JSON.stringify(said)}\n`, () => process.exit(0));
