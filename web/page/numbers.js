// Numbers as the command line prints them.

export const NONE = "–";

const known = (value) => typeof value === "number" && Number.isFinite(value);

/** With so many decimals. */
export function fixed(value, decimals) {
  return known(value) ? value.toFixed(decimals) : NONE;
}

/** With so many significant digits, without needless zeros of an exponent. */
export function significant(value, digits = 4) {
  if (!known(value)) return NONE;
  if (value === 0) return "0";
  const power = Math.floor(Math.log10(Math.abs(value)));
  return power >= -4 && power < 6 ? value.toFixed(Math.max(0, digits - 1 - power)) : value.toExponential(digits - 1);
}

export const ut = (value) => `${fixed(value, 3)} µT`;
export const percent = (value) => `${fixed(value, 2)} %`;
export const degrees = (value) => `${fixed(value, 2)}°`;

/** A p-value. */
export function chance(p) {
  if (!known(p)) return NONE;
  return p < 1e-99 ? "< 1e-99" : p < 1e-3 ? p.toExponential(0) : significant(p, 2);
}

const UNITS = { c: "°C", a: "A", ma: "mA", v: "V", w: "W", s: "s", m: "m", mps: "m/s", rpm: "rpm", hz: "Hz", pct: "%", deg: "°", rad: "rad", us: "µs", pa: "Pa", hpa: "hPa" };

/** A column with its unit, by the end of its name if the unit is not known; nothing is added if neither tells. */
export function labelled(name, unit = "") {
  const known = unit || (UNITS[/_([a-z]+)$/.exec(name)?.[1]] ?? "");
  return known ? `${name}, ${known}` : name;
}
