// The time of the emulated board. It is a function of the cycles that the core has executed and of the time that it has slept,
// so that a run is the same on every host. Has the shape of rp2040js's clocks.

class Alarm {
  constructor(clock, callback) {
    Object.assign(this, { clock, callback, at: 0, isSet: false });
  }

  schedule(delayNs) {
    this.cancel();
    this.at = this.clock.nanos + delayNs;
    this.isSet = true;
    this.clock.insert(this);
  }

  cancel() {
    if (this.isSet) this.clock.remove(this);
    this.isSet = false;
  }
}

export class Clock {
  constructor() {
    // At `baseCycles` of the core it was `baseNs`.
    Object.assign(this, { core: null, baseNs: 0, baseCycles: 0, nsPerCycle: 8, alarms: [], dueCycles: Infinity });
  }

  get nanos() {
    return this.core ? this.baseNs + (this.core.cycles - this.baseCycles) * this.nsPerCycle : 0;
  }

  get micros() {
    return this.nanos / 1000;
  }

  createAlarm(callback) {
    return new Alarm(this, callback);
  }

  setFrequency(hz) {
    this.baseNs = this.nanos;
    this.baseCycles = this.core.cycles;
    this.nsPerCycle = 1e9 / hz;
    this.rearm();
  }

  /** In the order of their times; those of one time in the order in which they were set. */
  insert(alarm) {
    const after = this.alarms.findIndex((other) => other.at > alarm.at);
    this.alarms.splice(after < 0 ? this.alarms.length : after, 0, alarm);
    this.rearm();
  }

  remove(alarm) {
    this.alarms.splice(this.alarms.indexOf(alarm), 1);
    this.rearm();
  }

  /** The cycle count at which the next alarm is due, so that the loop compares two numbers only. */
  rearm() {
    this.dueCycles = this.alarms.length ? this.cyclesAt(this.alarms[0].at) : Infinity;
  }

  cyclesAt(ns) {
    return this.baseCycles + (ns - this.baseNs) / this.nsPerCycle;
  }

  fire() {
    // A thousandth of a nanosecond of rounding must not make an alarm wait for a cycle that never comes.
    while (this.alarms.length && this.alarms[0].at <= this.nanos + 1e-3) {
      const alarm = this.alarms[0];
      alarm.cancel();
      alarm.callback();
    }
  }

  /** Lets time pass while no instruction is executed. */
  pass(ns) {
    this.baseNs += ns;
    this.rearm();
  }

  /** Sleeps up to the next alarm, at most until `endNs`. */
  sleep(endNs) {
    const until = this.alarms.length ? Math.min(endNs, this.alarms[0].at) : endNs;
    this.pass(Math.max(0, until - this.nanos));
    this.fire();
  }
}
