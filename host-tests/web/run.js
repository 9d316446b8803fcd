// node run.js SCENARIO '{"…": …}': runs one, and prints what it saw as one line of JSON.
import { report } from "./report.js";

const scenarios = { report };
const [, , name, given] = process.argv;
const said = await scenarios[name](JSON.parse(given));
console.log(JSON.stringify(said));
