// The stream of a board as a log: `H` and `L` lines, or those of a sketch that speaks MotionCal's language.

const OWN = ["t_s", "t_us", "mx_ut", "my_ut", "mz_ut", "heading_deg"];

export class Recording {
  /** `scale` is µT a count along each axis. */
  constructor(scale) {
    Object.assign(this, { scale, names: [], places: [], rows: [], last: null, offset: 0, lost: 0, foreign: [] });
  }

  get samples() {
    return this.rows.length || this.foreign.length;
  }

  columns(line) {
    this.places = line.split(",").slice(6).map((name) => {
      const own = OWN.includes(name) ? `board_${name}` : name;
      if (!this.names.includes(own)) this.names.push(own);
      return this.names.indexOf(own);
    });
  }

  /** Takes a line of a stream. */
  take(line) {
    if (line.startsWith("Raw:")) {
      this.foreign.push(line);
      return;
    }
    if (line.startsWith("H,")) {
      this.columns(line);
      return;
    }
    if (!line.startsWith("L,")) return;
    const [time, number, ...cells] = line.split(",").slice(1);
    const [ms, seq] = [Number(time), Number(number)];
    if (cells.length !== 3 + this.places.length || !Number.isFinite(ms) || !Number.isFinite(seq)) return;
    if (this.last && (ms < this.last.ms || seq <= this.last.seq)) {
      this.offset += this.last.ms + 1 - Math.min(ms, 0);
      this.rows.push("# the board restarted: its clock restarted");
    } else if (this.last && seq > this.last.seq + 1) {
      this.lost += seq - this.last.seq - 1;
      this.rows.push(`# lost ${seq - this.last.seq - 1} samples`);
    }
    this.last = { ms, seq };
    const counts = cells.slice(0, 3).map(Number);
    if (!counts.every(Number.isFinite)) return;
    const own = new Array(this.names.length).fill("");
    this.places.forEach((place, index) => { own[place] = cells[3 + index] === "-" ? "" : cells[3 + index]; });
    this.rows.push([((ms + this.offset) / 1000).toFixed(3), ...counts.map((count, axis) => count * this.scale[axis]), ...own].join(","));
  }

  /** The log. */
  text() {
    if (this.foreign.length) return `${this.foreign.join("\n")}\n`;
    const width = 4 + this.names.length;
    const rows = this.rows.map((row) => (row.startsWith("#") ? row : row + ",".repeat(width - row.split(",").length)));
    return `${["t_s", "mx_ut", "my_ut", "mz_ut", ...this.names].join(",")}\n${rows.join("\n")}\n`;
  }
}
