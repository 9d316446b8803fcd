// node run.js SCENARIO '{"…": …}': runs one, and prints what it saw as one line of JSON.
import { alone, timed } from "./alone.js";
import { cable, live, load, replay, serial, sketch } from "./board.js";
import { beside, hostile, report } from "./report.js";

const scenarios = { alone, beside, cable, hostile, live, load, replay, report, serial, sketch, timed };
const [, , name, given] = process.argv;
const said = await scenarios[name](JSON.parse(given));
// What is still open (a cable, a stream) does not keep the program.
process.stdout.write(`${JSON.stringify(said)}\n`, () => process.exit(0));
