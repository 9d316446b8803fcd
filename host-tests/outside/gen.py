#!/usr/bin/env python3
"""Seeded logs with a known truth, written from theory alone.

  gen.py KIND SPLIT INDEX -o LOG.csv      one log and LOG.json beside it
  gen.py --all dev -n 12                  dev/KIND/000.csv … for every kind
"""
import argparse, json, os, sys, zlib
import numpy as np
from scipy.interpolate import CubicSpline
from scipy.spatial.transform import Rotation as Rot
import motion, covs
from motion import G

DATA = "../../../shared/data"
KINDS = ["one", "nl", "strong", "two", "none", "deleted", "decoy", "decoygap", "level", "levelprior", "axes", "multi", "hum",
         "confounded", "magnet", "journey", "room", "real-sphere", "real-tilt", "real-qmc", "real-notime", "real-flight", "realdecoy"]

# Ranges of the two splits: the test half reaches further and has other column names.
P = {
    "dev": dict(F=(30, 60), dip=(25, 72), hard=(.05, 1.5), gain=.12, soft=.06, skew=.02, sigma=(.1, .6), turn=(.6, 1.4), rate=(10, 200),
                seconds=(30, 400), lsb=[0, 0, .0333, .092, .15], amp="current_a", temp="temp_c", rows=40000, mount=.08),
    "test": dict(F=(24, 66), dip=(8, 80), hard=(.02, 3.0), gain=.18, soft=.09, skew=.035, sigma=(.06, .9), turn=(.4, 2.0), rate=(10, 200),
                 seconds=(30, 400), lsb=[0, .0146, .03, .1, .2], amp="motor_a", temp="die_c", rows=40000, mount=.14),
}


def logu(rng, a, b):
    return float(np.exp(rng.uniform(np.log(a), np.log(b))))


# ---------------------------------------------------------------- noise
def noise(rng, n, colour, par):
    """Unit standard deviation, n×3."""
    w = rng.standard_normal((n + 400, 3))
    if colour == "white":
        x = w
    elif colour == "ar":
        from scipy.signal import lfilter
        x = lfilter([1], [1, -par], w, axis=0)
    elif colour == "ma":
        k = int(par)
        x = np.apply_along_axis(lambda c: np.convolve(c, np.ones(k) / k, "same"), 0, w)
    elif colour == "pink":
        f = np.fft.rfftfreq(len(w))
        f[0] = f[1]
        x = np.fft.irfft(np.fft.rfft(w, axis=0) * (f ** (-par / 2))[:, None], len(w), axis=0)
        x = x / x.std(axis=0) + .3 * rng.standard_normal(x.shape)
    x = x[200:200 + n]
    return x / x.std()


def draw_noise(rng, among=("white", "ar", "ma", "pink")):
    c = str(rng.choice(among))
    par = {"white": 0, "ar": float(rng.uniform(.3, .9)), "ma": int(rng.integers(3, 13)), "pink": float(rng.uniform(.8, 1.2))}[c]
    return c, par


# ---------------------------------------------------------------- world
class World:
    def __init__(self, rng, split, kind=None, T=None, rate=None, sigma=None, colours=("white", "ar", "ma", "pink"), among=None):
        p = self.p = P[split]
        self.rng = rng
        among = among or ["tumbling", "eights", "hand", "table", "rings", "acro"]
        for attempt in range(40):
            self.kind = kind or str(rng.choice(among))
            self.rate = rate or logu(rng, *p["rate"])
            self.T = T or logu(rng, *p["seconds"])
            if self.kind in ("hand", "acro", "table", "rings"):
                self.T = max(self.T, 60.0)
            self.T = min(self.T, p["rows"] / self.rate)
            k = int(np.ceil(100 / self.rate))
            fs = self.rate * k
            pre = int(np.ceil(.5 * fs))                           # half a second before the log, for delays
            nf = int(self.T * fs) + pre
            tf = np.arange(nf) / fs
            R, om, spec = motion.run(self.kind, rng, tf, fs, dict(turn=rng.uniform(*p["turn"]), tilt=rng.uniform(.05, .3)))
            self.F = rng.uniform(*p["F"])
            dip, dec = np.radians(rng.uniform(*p["dip"]) * rng.choice([-1, 1])), rng.uniform(-.4, .4)
            self.world = self.F * np.array([np.cos(dip) * np.cos(dec), np.cos(dip) * np.sin(dec), np.sin(dip)])
            self.fs, self.tf, self.R = fs, tf - pre / fs, R
            self.hf = R.inv().apply(self.world)
            pick = np.arange(pre, nf, k)
            self.pick, self.t = pick, self.tf[pick]
            self.n = len(pick)
            self.om, self.spec = om[pick], spec[pick]
            self.thrust = np.linalg.norm(spec[pick], axis=1) / G
            S = p["soft"] * rng.standard_normal((3, 3))
            K = np.triu(p["skew"] * rng.standard_normal((3, 3)), 1)
            self.A = np.diag(1 + p["gain"] * rng.uniform(-1, 1, 3)) @ (np.eye(3) + K) @ (np.eye(3) + (S + S.T) / 2)
            self.A = self.A @ Rot.from_rotvec(p["mount"] * rng.standard_normal(3) / np.sqrt(3)).as_matrix()
            hard = rng.standard_normal(3)
            self.b = hard / np.linalg.norm(hard) * logu(rng, *p["hard"]) * self.F
            self.sigma = sigma or logu(rng, *p["sigma"])
            self.colour, self.par = draw_noise(rng, colours)
            self.h = self.hf[pick]
            if self.n < 300:
                continue
            # Enough attitude? One-sigma of the corrected vector in its worst direction, noise taken 4 times as dear.
            J = self.base_columns(self.h)
            if self.kind == "level":
                break
            C = np.linalg.pinv(J.T @ J)
            worst = 0
            for v in np.random.default_rng(0).standard_normal((100, 3)):
                v /= np.linalg.norm(v)
                # change of the corrected vector at v: offset part + matrix part
                D = np.zeros((3, 9))
                D[:, :3] = np.eye(3)
                D[:, 3:] = matrix_part(v[None])[0]
                worst = max(worst, np.linalg.eigvalsh(D @ C @ D.T)[-1])
            if np.sqrt(worst) * self.sigma * (4 if self.colour != "white" else 1.5) < .004 * self.F:
                break
        else:
            raise RuntimeError("no attitude")

    def base_columns(self, h):
        u = h / np.linalg.norm(h, axis=1)[:, None]
        return np.hstack([u, np.einsum("ni,nij->nj", u, matrix_part(u))])

    def measured(self, effects, amps):
        """Noise-free output with the listed effects at the given amplitudes."""
        h = self.h
        for e, a in zip(effects, amps):
            if e.stage == 0:
                h = e.apply(self, h, a)
        x = h @ self.A.T + self.b
        for stage in (1, 2, 3):
            for e, a in zip(effects, amps):
                if e.stage == stage:
                    x = e.apply(self, x, a)
        return x

    def visible(self, e, a):
        """Rms of the error in magnitude (µT at the sensor's scale) that the nine base numbers cannot take up."""
        d = (self.measured([e], [a]) - self.measured([], []))
        C = np.linalg.inv(self.A)
        u = self.h / np.linalg.norm(self.h, axis=1)[:, None]
        r = np.einsum("ni,ni->n", u, d @ C.T)
        J = self.base_columns(self.h)
        r = r - J @ np.linalg.lstsq(J, r, rcond=None)[0]
        return r.std()

    def dip_rms(self, h):
        a = self.spec
        c = np.einsum("ni,ni->n", h, a) / np.linalg.norm(h, axis=1) / np.linalg.norm(a, axis=1)
        return np.degrees(np.std(np.arccos(np.clip(c, -1, 1))))

    def scale(self, e, strength, cap=.2):
        """Amplitude for which the visible error is `strength` sigmas; the raw disturbance stays under cap·F."""
        if isinstance(e, Lag):
            # Strength: the field's error in floors. Only the dip shows it, above what linear accelerations do to the dip.
            floor = np.hypot(self.dip_rms(self.h), np.degrees(self.sigma / self.F))
            a = logu(self.rng, .008, .1)
            rms = lambda x: np.sqrt(np.mean((e.apply(self, self.h, x) - self.h) ** 2)) / self.sigma
            a = float(min(max(a * strength / rms(a), .006), .1))
            d = self.dip_rms(e.apply(self, self.h, a))
            extra = np.sqrt(max(d * d - self.dip_rms(self.h) ** 2, 0))
            e.tau, e.dip_ratio = a, round(float(extra / floor), 3)
            return a, float(rms(a)) if extra > .35 * floor else 0.0
        a = 1e-3
        for _ in range(8):
            v = self.visible(e, a)
            if v < 1e-9:
                return 0., 0.
            a = a * strength * self.sigma / v
            raw = np.sqrt(np.mean(np.sum((self.measured([e], [a]) - self.measured([], [])) ** 2, axis=1) / 3))
            raw0 = raw
            if raw > cap * self.F:
                a *= cap * self.F / raw
        if isinstance(e, (NonLinear, Cross)):                       # no further than a sensor that still answers: every slope over 0.6
            x = self.measured([], [])[:: max(1, self.n // 400)]
            eps = 1e-3
            for _ in range(60):
                J = np.stack([(e.apply(self, x + eps * np.eye(3)[j], a) - e.apply(self, x, a)) / eps for j in range(3)], axis=-1)
                if np.linalg.svd(J, compute_uv=False).min() > .6:
                    break
                a *= .9
        return a, float(self.visible(e, a) / self.sigma)


def matrix_part(u):
    n = len(u)
    M = np.zeros((n, 3, 6))
    for k, (i, j) in enumerate([(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)]):
        M[:, i, k] = u[:, j]
    return M


# ---------------------------------------------------------------- effects
class Effect:
    stage, column = 1, None

    def norm(self, col):
        c = np.asarray(col, float)
        return (c - c.mean()) / (c.max() - c.min() + 1e-12)


class Offset(Effect):
    """A field at the sensor or a zero that goes with a column: prompt, delayed or squared."""
    def __init__(self, rng, name, col, t, variant=None):
        self.column, self.variant = name, variant
        c = np.asarray(col, float)
        if variant == "delay":
            self.delay = float(rng.uniform(.15, .9))
            c = np.interp(t - self.delay, t, c)
        elif variant == "square":
            c = c * np.abs(c) if c.min() < 0 else c ** 2
        self.u = self.norm(c)
        d = rng.standard_normal(3)
        self.d = d / np.linalg.norm(d)
        self.id = f"offset:{name}"
        self.accept = [self.id]
        self.full = self.id + {"delay": "@delay", "square": "^2", None: ""}[variant]

    def apply(self, w, x, a):
        return x + a * np.outer(self.u, self.d)


class Gain(Effect):
    stage = 3

    def __init__(self, rng, name, col):
        self.column, self.u = name, self.norm(col)
        self.g = 1 + .5 * rng.uniform(-1, 1, 3) if rng.random() < .6 else rng.standard_normal(3)
        self.g = self.g / np.abs(self.g).max()
        self.id = self.full = f"gain:{name}"
        iso = np.ptp(self.g) < .5
        self.accept = [self.id] + ([f"field:{name}"] if iso else [])

    def apply(self, w, x, a):
        return x * (1 + a / 50 * np.outer(self.u, self.g))


class Field(Effect):
    stage = 0

    def __init__(self, rng, name, col):
        self.column, self.u = name, self.norm(col)
        self.id = self.full = f"field:{name}"
        self.accept = [self.id, f"gain:{name}"]

    def apply(self, w, h, a):
        return h * (1 + a / 50 * self.u)[:, None]


class Drift(Effect):
    id = full = "drift"
    accept = ["drift"]

    def __init__(self, rng, t):
        d = rng.standard_normal(3)
        self.d, self.u = d / np.linalg.norm(d), self.norm(t)

    def apply(self, w, x, a):
        return x + a * np.outer(self.u, self.d)


class Step(Effect):
    id = full = "step"
    accept = ["step"]

    def __init__(self, rng, t, at=None):
        d = rng.standard_normal(3)
        self.d = d / np.linalg.norm(d)
        self.at = float(t[0] + (t[-1] - t[0]) * (rng.uniform(.2, .8) if at is None else at))
        self.u = (t >= self.at).astype(float)

    def apply(self, w, x, a):
        return x + a * np.outer(self.u, self.d)


class Tone(Effect):
    id = full = "periodic"
    accept = ["periodic"]

    def __init__(self, rng, t, rate, f=None, when=None):
        self.f = float(f or rng.uniform(1.1, .47 * rate))
        when = t if when is None else when
        d, e = rng.standard_normal(3), rng.standard_normal(3) * rng.uniform(0, 1)
        ph = rng.uniform(0, 6.28)
        self.v = np.outer(np.sin(2 * np.pi * self.f * when + ph), d) + np.outer(np.cos(2 * np.pi * self.f * when + ph), e)

    def apply(self, w, x, a):
        return x + a * self.v


class NonLinear(Effect):
    """A core or amplifier that saturates (tanh), or whose transfer bends (square, cube) about the sensor's zero."""
    stage = 2
    id = full = "nonlinearity"
    accept = ["nonlinearity"]

    def __init__(self, rng):
        self.form = str(rng.choice(["tanh", "poly", "square"]))
        self.k = rng.uniform(.4, 1, 3) * (1 if self.form == "tanh" else rng.choice([-1, 1], 3))
        if rng.random() < .3:
            self.k[rng.permutation(3)[:2]] *= .05
        self.mix = rng.uniform(0, 1)

    def apply(self, w, x, a):
        s = 100.0
        if self.form == "tanh":
            L = s / np.sqrt(np.maximum(3 * a * self.k / 10, 1e-12))
            return L * np.tanh(x / L)
        if self.form == "square":
            return x + a / 10 * self.k * x ** 2 / s
        return x + a / 10 * self.k * ((1 - self.mix) * x ** 2 / s - self.mix * x ** 3 / s ** 2)


class Cross(Effect):
    """Anisotropic magnetoresistor: the field across divides the sensitivity."""
    stage = 2
    id = full = "cross-axis"
    accept = ["cross-axis"]

    def __init__(self, rng):
        self.k = np.zeros((3, 3))
        pairs = [(0, 1), (1, 0), (0, 2), (2, 0), (1, 2), (2, 1)]
        for i in rng.permutation(6)[:rng.integers(1, 4)]:
            self.k[pairs[i]] = rng.uniform(.5, 1) * rng.choice([-1, 1])

    def apply(self, w, x, a):
        return x / (1 + np.clip(a / 10 * (x @ self.k.T) / 100.0, -.6, 3))


class Lag(Effect):
    """A pure delay, a first-order filter, or eddy currents (anisotropic)."""
    stage = 0
    id = full = "lag"
    accept = ["lag"]

    def __init__(self, rng):
        self.form = str(rng.choice(["delay", "filter"]))

    def apply(self, w, h, a):
        if self.form == "delay":
            return CubicSpline(w.tf, w.hf)(w.t - max(a, 0))
        k = 1 - np.exp(-1 / w.fs / max(a, 1e-5))
        from scipy.signal import lfilter, lfilter_zi
        y = lfilter([k], [1, -(1 - k)], w.hf, axis=0, zi=((1 - k) * w.hf[:1]))[0]
        return y[w.pick]


# ---------------------------------------------------------------- making a log
def columns_for(rng, w, need=()):
    """A set of candidate columns: causes' signals and decoys, none too alike."""
    p, t = w.p, w.t
    amps = covs.current(rng, t, w.thrust if w.kind == "acro" else None)
    pool = {p["amp"]: amps, p["temp"]: covs.temperature(rng, t), "servo_deg": covs.servo(rng, t), "fan_rpm": covs.fan(rng, t),
            "height_m": covs.height(rng, t), "vbat_v": covs.battery(rng, t, amps if rng.random() < .4 else None),
            "mode": covs.mode(rng, t), "lamp_on": covs.switch(rng, t), "rssi_db": covs.walk(rng, t, 4.0), "load_pct": 50 + covs.walk(rng, t, 9.0),
            "humidity_pct": covs.wander(rng, t)}
    keep = list(need)
    extra = [k for k in pool if k not in keep]
    keep += [str(k) for k in rng.permutation(extra)[:rng.integers(1, 5)]]
    return {k: pool[k] for k in pool if k in keep}


def alike(cols, t, name, others=None):
    """The share of a column that time, a step and the other columns explain."""
    y = np.asarray(cols[name], float)
    X = [np.ones(len(t)), t] + [np.asarray(c, float) for k, c in cols.items() if k != name and (others is None or k in others)]
    X = np.column_stack([(x - x.mean()) / (x.std() + 1e-12) if i else x for i, x in enumerate(X)])
    r = y - X @ np.linalg.lstsq(X, y, rcond=None)[0]
    best = 1 - r.var() / y.var()
    for q in np.linspace(.1, .9, 17):
        s = (t > t[0] + q * (t[-1] - t[0])).astype(float)
        best = max(best, np.corrcoef(s, y)[0, 1] ** 2)
    return best


def pick_effect(rng, w, cols, what):
    p, t = w.p, w.t
    col = {"temp": p["temp"], "amp": p["amp"]}
    if what == "temp-offset":
        return Offset(rng, col["temp"], cols[col["temp"]], t)
    if what == "temp-gain":
        return Gain(rng, col["temp"], cols[col["temp"]])
    if what == "amp-offset":
        return Offset(rng, col["amp"], cols[col["amp"]], t)
    if what == "amp-delay":
        return Offset(rng, col["amp"], cols[col["amp"]], t, "delay")
    if what == "amp-square":
        return Offset(rng, col["amp"], cols[col["amp"]], t, "square")
    if what == "servo-offset":
        return Offset(rng, "servo_deg", cols["servo_deg"], t)
    if what == "fan-offset":
        return Offset(rng, "fan_rpm", cols["fan_rpm"], t)
    if what == "height-field":
        return Field(rng, "height_m", cols["height_m"])
    if what == "drift":
        return Drift(rng, t)
    if what == "step":
        return Step(rng, t)
    if what == "tone":
        return Tone(rng, t, w.rate)
    if what == "lag":
        return Lag(rng)
    if what == "nonlinearity":
        return NonLinear(rng)
    if what == "cross-axis":
        return Cross(rng)
    raise ValueError(what)


NEEDS = {"temp-offset": "temp", "temp-gain": "temp", "amp-offset": "amp", "amp-delay": "amp", "amp-square": "amp",
         "servo-offset": "servo_deg", "fan-offset": "fan_rpm", "height-field": "height_m"}
PLAIN = ["temp-offset", "temp-gain", "amp-offset", "amp-delay", "amp-square", "servo-offset", "fan-offset", "height-field", "drift", "step",
         "tone", "lag"]


def need_of(w, what):
    k = NEEDS.get(what)
    return w.p.get(k, k) if k else None


def build(rng, split, wanted, strengths=(1.5, 20), world=None, cap=.2, need_alike=.5, **kw):
    """A world with the wanted effects at log-uniform strengths; retried until each reaches its least."""
    for attempt in range(60):
        k = dict(kw)
        if "lag" in wanted and "kind" not in k:
            k["among"] = ["tumbling", "eights", "rings", "table"]
        w = World(rng, split, **k)
        need = [c for c in (need_of(w, x) for x in wanted) if c]
        cols = columns_for(rng, w, need)
        if any(alike(cols, w.t, c) > need_alike for c in need):
            continue
        effects = [pick_effect(rng, w, cols, x) for x in wanted]
        want = [logu(rng, *strengths) for _ in effects]
        got = [w.scale(e, s, cap) for e, s in zip(effects, want)]
        low = strengths[0] * .8
        if all(g[1] >= low for g in got):
            return w, cols, effects, [g[0] for g in got], [g[1] for g in got]
    raise RuntimeError(f"cannot build {wanted}")


def entry(e, s):
    d = dict(id=e.full, accept=e.accept, strength=round(s, 2))
    for k in ("delay", "at", "f", "form", "tau", "dip_ratio"):
        if hasattr(e, k):
            d[k] = getattr(e, k)
    return d


def sensors(rng, w, x, temp=None):
    """Noise, quantisation, a slow sensor in a fast log, gyro and accelerometer with noise of their own."""
    x = x + w.sigma * noise(rng, w.n, w.colour, w.par)
    w.lsb = float(rng.choice(w.p["lsb"]))
    w.lsb = w.lsb if w.lsb < 1.5 * w.sigma else 0.0
    if w.lsb:
        x = np.round(x / w.lsb) * w.lsb
    w.repeats = 1
    if rng.random() < .12 and w.rate > 60 and w.n > 3000:
        w.repeats = int(rng.integers(2, 4))
        x = x[(np.arange(w.n) // w.repeats) * w.repeats]
    acc = w.spec + .03 * rng.standard_normal(w.spec.shape) + rng.uniform(-.05, .05, 3)
    if w.kind in ("acro", "level"):
        acc += .4 * rng.standard_normal(acc.shape)
    gyr = w.om + .004 * rng.standard_normal(w.om.shape) + rng.uniform(-.01, .01, 3)
    return x, acc, gyr


def write(path, t, x, acc=None, gyr=None, cols=None, blanks=None, comment="made"):
    names, data, fmt = [], [], []
    if t is not None:
        names, data, fmt = ["t_s"], [t], ["%.4f"]
    for i, a in enumerate("xyz"):
        names.append(f"m{a}_ut"); data.append(x[:, i]); fmt.append("%.4f")
    if acc is not None:
        for i, a in enumerate("xyz"):
            names.append(f"a{a}_mps2"); data.append(acc[:, i]); fmt.append("%.4f")
    if gyr is not None:
        for i, a in enumerate("xyz"):
            names.append(f"g{a}_radps"); data.append(gyr[:, i]); fmt.append("%.5f")
    for k, c in (cols or {}).items():
        names.append(k); data.append(c); fmt.append("%.4f")
    n = len(x)
    txt = [np.char.mod(f, np.asarray(d, float)) for f, d in zip(fmt, data)]
    if blanks:
        for k, m in blanks.items():
            i = names.index(k)
            txt[i] = txt[i].copy()
            txt[i][m] = ""
    with open(path, "w") as f:
        f.write(",".join(names) + "\n")
        for row in zip(*txt):
            f.write(",".join(row) + "\n")


def about(w, **more):
    d = dict(motion=w.kind, rate=round(w.rate, 1), seconds=round(w.T, 1), rows=w.n, F=round(w.F, 2), sigma=round(w.sigma, 4), noise=w.colour,
             noise_par=w.par, lsb=getattr(w, "lsb", 0), repeats=getattr(w, "repeats", 1), hard_over_F=round(float(np.linalg.norm(w.b) / w.F), 2))
    d.update(more)
    return d


def finish(path, rng, w, cols, effects, amps, strengths, expect="named", drop=(), truth=None, blanks=None, mags=None, gyro=True, accel=True, times=None, **more):
    x, acc, gyr = sensors(rng, w, w.measured(effects, amps))
    if mags is not None:
        x = mags(x)
    cols = {k: v for k, v in cols.items() if k not in drop}
    lag = any(isinstance(e, Lag) for e in effects)
    g, a = (gyro or lag), (accel or lag)
    write(path, w.t if times is None else times, x, acc if a else None, gyr if g else None, cols, blanks)
    return about(w, expect=expect, truth=[entry(e, s) for e, s in zip(effects, strengths)] if truth is None else truth,
                 hidden=[entry(e, s) for e, s in zip(effects, strengths)], columns=list(cols), **more)


def imu(rng):
    return dict(gyro=bool(rng.random() < .6), accel=bool(rng.random() < .7))


# ---------------------------------------------------------------- kinds
def k_one(rng, split, path):
    colour = str(rng.choice(["white", "ar", "ma", "pink"], p=[.3, .25, .15, .3]))
    w = build(rng, split, [str(rng.choice(PLAIN))], colours=(colour,))
    return finish(path, rng, *w, **imu(rng))


def k_nl(rng, split, path):
    w = build(rng, split, [str(rng.choice(["nonlinearity", "nonlinearity", "cross-axis"]))], strengths=(1.5, 40), cap=.4)
    return finish(path, rng, *w, **imu(rng))


def k_strong(rng, split, path):
    what = str(rng.choice(["amp-delay", "amp-square", "temp-gain", "height-field", "step"]))
    w = build(rng, split, [what], strengths=(12, 20), cap=.35)
    return finish(path, rng, *w, **imu(rng))


def k_two(rng, split, path):
    k = 2 if rng.random() < .65 else 3
    for _ in range(50):
        what = [str(x) for x in rng.permutation(PLAIN + ["nonlinearity", "cross-axis"])[:k]]
        bases = [NEEDS.get(x, x) for x in what]
        if len(set(bases)) == len(bases) and not {"nonlinearity", "cross-axis"} <= set(what):
            break
    w = build(rng, split, what, cap=.2)
    return finish(path, rng, *w, **imu(rng))


def k_none(rng, split, path):
    c = str(rng.choice(["white", "ar", "ma", "pink"], p=[.25, .25, .2, .3]))
    w = World(rng, split, colours=(c,))
    return finish(path, rng, w, columns_for(rng, w), [], [], [], expect="complete", **imu(rng))


CAUSED = ["temp-offset", "temp-gain", "amp-offset", "amp-delay", "amp-square", "servo-offset", "fan-offset", "height-field"]


def k_deleted(rng, split, path):
    w, cols, e, a, s = build(rng, split, [str(rng.choice(CAUSED))])
    return finish(path, rng, w, cols, e, a, s, expect="unexplained", drop=[e[0].column], truth=[], **imu(rng))


def gaps(rng, n, share):
    m = np.zeros(n, bool)
    for _ in range(400):
        if m.mean() >= share:
            break
        k = int(n * rng.uniform(.01, .06)) if rng.random() < .8 else int(rng.integers(1, 30))
        i = int(rng.integers(0, n - k))
        m[i:i + k] = True
    return m


def k_decoy(rng, split, path, gap=False):
    for _ in range(30):
        w, cols, e, a, s = build(rng, split, [str(rng.choice([c for c in CAUSED if c != "amp-square"]))], strengths=(2, 20))
        rho = float(rng.uniform(.7, .97))
        cols = dict(cols)
        twin = "twin" if split == "dev" else "other"
        cols[twin] = covs.correlated(rng, w.t, np.asarray(cols[e[0].column], float), rho)
        # what of the effect the twin cannot imitate, in floors: under about one no log can tell
        apart = s[0] * np.sqrt(1 - rho ** 2)
        if apart * np.sqrt(w.n) > 60:
            break
    blanks = {e[0].column: gaps(rng, w.n, rng.uniform(.05, .25))} if gap else None
    return finish(path, rng, w, cols, e, a, s, blanks=blanks, rho=rho, apart=float(apart), twin=twin, **imu(rng))


def k_decoygap(rng, split, path):
    return k_decoy(rng, split, path, gap=True)


def k_level(rng, split, path):
    what = str(rng.choice(["temp-offset", "amp-offset", "servo-offset", "step", "amp-square"]))
    w = build(rng, split, [what], kind="level", strengths=(2, 12))
    return finish(path, rng, *w, gyro=True, accel=True)


def k_levelprior(rng, split, path):
    """A level flight of a board whose earlier calibration log (all attitudes, nothing hidden, no columns) lies beside it."""
    what = str(rng.choice(["temp-offset", "amp-offset", "servo-offset", "step", "amp-square"]))
    w, cols, e, a, s = build(rng, split, [what], kind="level", strengths=(2, 12))
    v = World(rng, split, among=["tumbling", "rings", "eights"], T=rng.uniform(40, 120), rate=w.rate, sigma=w.sigma, colours=(w.colour,))
    v.A, v.b, v.par = w.A, w.b, w.par
    v.F, v.world = w.F, w.world
    v.hf = v.R.inv().apply(w.world)
    v.h = v.hf[v.pick]
    x, acc, gyr = sensors(rng, v, v.measured([], []))
    write(os.path.splitext(path)[0] + ".prior.csv", v.t, x, acc, gyr)
    return finish(path, rng, w, cols, e, a, s, gyro=True, accel=True, prior=True)


def k_axes(rng, split, path):
    """A driver with its axes in a wrong order or with wrong signs."""
    import itertools, wmm
    w = World(rng, split, among=["hand", "hand", "eights", "tumbling", "table"])
    at = rng.random() < .5                                          # said where: the hemisphere is decidable
    if at:
        while True:
            lat, lon = round(rng.uniform(-60, 65), 2), round(rng.uniform(-170, 170), 2)
            f = np.array(wmm.field(lat, lon, 0))
            if abs(np.degrees(np.arctan2(f[2], np.hypot(f[0], f[1])))) > 12:
                break
        w.world, w.F = f, float(np.linalg.norm(f))
        w.hf = w.R.inv().apply(f)
        w.h = w.hf[w.pick]
    alls = []
    for q in itertools.permutations(range(3)):
        for s in itertools.product([1, -1], repeat=3):
            M = np.zeros((3, 3)); M[range(3), q] = s
            alls.append(M)
    half = [np.diag(s) for s in ([1, -1, -1], [-1, 1, -1], [-1, -1, 1])]
    if rng.random() < .25:
        M, form = half[rng.integers(3)], "turned by 180 degrees"
    elif at and rng.random() < .3:
        M, form = -np.eye(3), "all three signs (mirrored)"
    else:
        while True:
            M = alls[rng.integers(48)]
            if not np.allclose(M, np.eye(3)) and not np.allclose(M, -np.eye(3)):
                break
        form = "proper" if np.linalg.det(M) > 0 else "improper"
    cols = columns_for(rng, w)
    return finish(path, rng, w, cols, [], [], [], truth=[dict(id="axis-order", accept=["axis-order"], strength=1, form=form, matrix=M.tolist())],
                  mags=lambda x: x @ M.T, gyro=True, accel=True, **(dict(args=["--at", f"{lat},{lon},2026-01-01"]) if at else {}))


def k_multi(rng, split, path):
    """Two or three steps, or two or three tones."""
    m = int(rng.integers(2, 4))
    for _ in range(60):
        w = World(rng, split)
        if rng.random() < .5:
            at = np.sort(rng.uniform(.12, .88, m))
            if np.diff(at).min() < .12:
                continue
            effects = [Step(rng, w.t, a) for a in at]
        else:
            if w.rate < 15:
                continue
            f = np.sort(rng.uniform(1.2, .46 * w.rate, m))
            if np.diff(f).min() < .4:
                continue
            effects = [Tone(rng, w.t, w.rate, x) for x in f]
        got = [w.scale(e, logu(rng, 2, 12)) for e in effects]
        if all(g[1] > 1.5 for g in got):
            break
    for i, e in enumerate(effects[1:], 2):
        e.full = f"{e.id}#{i}"
    return finish(path, rng, w, columns_for(rng, w), effects, [g[0] for g in got], [g[1] for g in got], **imu(rng))


def k_hum(rng, split, path):
    """A tone sampled evenly, stamped on arrival."""
    for _ in range(60):
        w = World(rng, split)
        if w.rate < 12:
            continue
        e = Tone(rng, w.t, w.rate)
        a, s = w.scale(e, logu(rng, 2, 15))
        if s > 1.5:
            break
    j = float(rng.uniform(.3, 2.0))
    stamp = w.t + np.abs(rng.standard_normal(w.n)) * j / w.rate
    stamp = np.maximum.accumulate(stamp)
    return finish(path, rng, w, columns_for(rng, w), [e], [a], [s], times=stamp, jitter_samples=j, **imu(rng))


def k_confounded(rng, split, path):
    """Temperature that rises straight with time: offset over it and drift are one column."""
    for _ in range(60):
        w = World(rng, split)
        T = w.p["temp"]
        col = 20 + rng.uniform(4, 15) * (w.t / w.T) + .02 * rng.standard_normal(w.n)
        cols = {k: v for k, v in columns_for(rng, w).items() if k != T}
        cols[T] = np.round(col, 2)
        e = Offset(rng, T, cols[T], w.t)
        a, s = w.scale(e, logu(rng, 2, 12))
        if s > 1.6:
            break
    return finish(path, rng, w, cols, [e], [a], [s], expect="confounded", both=[e.id, "drift"], **imu(rng))


def k_magnet(rng, split, path):
    """A passing magnet (a burst of one to three seconds) and, in half of them, an effect beside it."""
    if rng.random() < .5:
        w, cols, e, a, s = build(rng, split, [str(rng.choice(["temp-offset", "amp-offset", "step", "drift"]))], strengths=(3, 15))
    else:
        w = World(rng, split)
        cols, e, a, s = columns_for(rng, w), [], [], []
    at, width = w.T * rng.uniform(.15, .85), rng.uniform(.3, 1.0)
    d = rng.standard_normal(3)
    d *= rng.uniform(15, 120) * w.sigma / np.linalg.norm(d)
    bump = np.outer(1 / (1 + ((w.t - at) / width) ** 2) ** 1.5, d)
    return finish(path, rng, w, cols, e, a, s, expect="named" if e else "complete", mags=lambda x: x + bump, burst=dict(at=at, width=width), **imu(rng))


def k_journey(rng, split, path):
    """A journey of some hundred kilometres: the known field changes along the track. Nothing is missing."""
    import wmm
    w = World(rng, split, among=["tumbling", "rings", "acro", "table"], T=rng.uniform(120, 400), rate=rng.uniform(10, 60))
    lat0, lon0 = rng.uniform(-55, 60), rng.uniform(-170, 170)
    km, brg = rng.uniform(200, 900), rng.uniform(0, 2 * np.pi)
    s = w.t / w.T + .05 * np.sin(2 * np.pi * 2 * w.t / w.T)
    lat = lat0 + km / 111.2 * np.cos(brg) * s
    lon = lon0 + km / 111.2 / np.cos(np.radians(lat0)) * np.sin(brg) * s
    hgt = 500 + rng.uniform(1000, 9000) * np.sin(np.pi * np.clip(s, 0, 1)) ** .5
    k = np.linspace(0, w.n - 1, 60).astype(int)
    ned = np.array([wmm.field(lat[i], lon[i], hgt[i] / 1000.) for i in k])
    world = np.column_stack([np.interp(np.arange(w.n), k, ned[:, j]) for j in range(3)])
    w.h = w.R[w.pick].inv().apply(world)
    w.F = float(np.linalg.norm(world, axis=1).mean())
    cols = {k: v for k, v in columns_for(rng, w).items() if k != "height_m"}
    e, a, st = [], [], []
    if rng.random() < .5:
        need = w.p["temp"]
        cols[need] = covs.temperature(rng, w.t)
        e = [Offset(rng, need, cols[need], w.t)]
        g = w.scale(e[0], logu(rng, 3, 12))
        a, st = [g[0]], [g[1]]
    cols = dict(cols, lat_deg=None, lon_deg=None, height_m=None)
    cols["lat_deg"], cols["lon_deg"], cols["height_m"] = lat, lon, hgt
    rel = float(np.std(np.linalg.norm(world, axis=1)) / w.sigma)
    return finish(path, rng, w, cols, e, a, st, expect="named" if e else "complete", field_spread_sigmas=rel, lat0=lat0, lon0=lon0, gyro=True, accel=True)


def k_room(rng, split, path):
    """Carried through a room: the field follows the place, which no column tells."""
    w = World(rng, split, among=["hand", "eights", "tumbling"])
    fs = covs.fs_of(w.t)
    place = motion.lowpass(rng, w.n, fs, rng.uniform(.05, .2), 1.0, 3)
    # a gradient and a magnetised bar: field at the place, in the world
    Gm = rng.standard_normal((3, 3)); Gm = (Gm + Gm.T) / 2; Gm -= np.eye(3) * np.trace(Gm) / 3
    extra = place @ Gm.T
    extra *= w.sigma * logu(rng, 3, 20) / extra.std()
    w.h = w.R[w.pick].inv().apply(w.world + extra)
    return finish(path, rng, w, columns_for(rng, w), [], [], [], expect="unexplained", **imu(rng))


# ---------------------------------------------------------------- real recordings
def real(name):
    L = [l for l in open(f"{DATA}/{name}.csv") if not l.startswith("#")]
    head = L[0].strip().split(",")
    a = np.array([[float(v) if v else np.nan for v in l.split(",")] for l in L[1:]])
    return {h: a[:, i] for i, h in enumerate(head)}


class RealWorld(World):
    """A recording as a world: its own ellipsoid stands for the truth."""
    def __init__(self, rng, split, d, unit=1.0, calibrated=False):
        self.rng, self.p, self.kind = rng, P[split], "real"
        self.d = d
        m = np.column_stack([d[k] for k in (("mx_ut", "my_ut", "mz_ut") if "mx_ut" in d else ("mx_counts", "my_counts", "mz_counts"))]) * unit
        self.m, self.n = m, len(m)
        self.t = d.get("t_s")
        self.clock = self.t if self.t is not None else np.arange(self.n) / 10.0
        self.clock = self.clock + np.arange(self.n) * 1e-9
        self.T = self.clock[-1] - self.clock[0]
        self.rate = (self.n - 1) / self.T
        # A flight has too little attitude for an ellipsoid: it was calibrated on board.
        C, b, F = (np.eye(3), np.zeros(3), float(np.linalg.norm(m, axis=1).mean())) if calibrated else ellipsoid(m)
        self.A, self.b, self.F = np.linalg.inv(C), b, F
        self.h = (m - b) @ C.T
        self.noise_free = m
        r = np.linalg.norm(self.h, axis=1) - F
        self.sigma = .014 * F if calibrated else float(r.std())
        self.colour, self.par = "real", 0
        self.thrust = None

    def measured(self, effects, amps):
        h = self.h
        for e, a in zip(effects, amps):
            if e.stage == 0:
                h = e.apply(self, h, a)
        x = h @ self.A.T + self.b
        for stage in (1, 2, 3):
            for e, a in zip(effects, amps):
                if e.stage == stage:
                    x = e.apply(self, x, a)
        return x


def ellipsoid(m):
    """Geometric least squares with a weak prior, robust (soft L1); recordings only."""
    from scipy.optimize import least_squares
    c = (m.max(0) + m.min(0)) / 2
    F = np.median(np.linalg.norm(m - c, axis=1))
    iu = np.triu_indices(3)

    def unpack(q):
        C = np.zeros((3, 3)); C[iu] = q[3:]
        return C, q[:3] * F + c

    def fun(q):
        C, b = unpack(q)
        r = np.linalg.norm((s - b) @ C.T, axis=1) / F - 1
        return np.concatenate([r / .01, (q[[3, 6, 8]] - 1) / .2 * .3, q[[4, 5, 7]] / .15 * .3])
    s = m[:: max(1, len(m) // 3000)]
    q0 = np.concatenate([np.zeros(3), np.eye(3)[iu]])
    q = least_squares(fun, q0, loss="soft_l1").x
    C, b = unpack(q)
    return C, b, F


def segment(rng, d, rows):
    n = len(next(iter(d.values())))
    if rows >= n:
        return d
    i = int(rng.integers(0, n - rows))
    return {k: v[i:i + rows] for k, v in d.items()}


def inject(rng, split, d, path, unit=1.0, calibrated=False, time=True, strengths=(2, 12), what=None, cap=.2, least=1.2):
    w = RealWorld(rng, split, d, unit, calibrated)
    t = w.clock
    p = w.p
    timeless = ["amp-offset", "temp2-offset", "temp2-gain", "servo-offset", "fan-offset", "nonlinearity", "amp-square"]
    choices = timeless + (["step", "drift", "tone", "amp-delay"] if time else [])
    for _ in range(80):
        pool = {p["amp"]: covs.current(rng, t), "board_c": covs.temperature(rng, t), "servo_deg": covs.servo(rng, t), "fan_rpm": covs.fan(rng, t),
                "mode": covs.mode(rng, t), "lamp_on": covs.switch(rng, t), "load_pct": 50 + covs.walk(rng, t, 9.), "vbat_v": covs.battery(rng, t)}
        x = what or str(rng.choice(choices))
        need = {"temp2-offset": "board_c", "temp2-gain": "board_c", "servo-offset": "servo_deg", "fan-offset": "fan_rpm"}.get(x, p["amp"] if x.startswith("amp") else None)
        if x == "temp2-offset":
            e = Offset(rng, "board_c", pool["board_c"], t)
        elif x == "temp2-gain":
            e = Gain(rng, "board_c", pool["board_c"])
        else:
            e = pick_effect(rng, w, pool, x) if x != "tone" else Tone(rng, t, w.rate, rng.uniform(1.1, min(.4 * w.rate, 20)))
        keep = ([need] if need else []) + [str(k) for k in rng.permutation([k for k in pool if k != need])[:rng.integers(1, 4)]]
        cols = {k: pool[k] for k in pool if k in keep}
        if need and alike(cols, t, need) > .5:
            continue
        a, s = w.scale(e, logu(rng, *strengths), cap)
        if s >= least:
            break
    else:
        raise RuntimeError("cannot inject")
    x = w.measured([e], [a])
    if "mx_counts" in d:
        x = np.round(x / unit) * unit
    for k, v in d.items():
        if k not in ("t_s",) and not k.startswith(("m", "a", "g")):
            cols[k] = v
        if k.startswith("motor") or k == "throttle_us":
            cols[k] = v
    acc = np.column_stack([d[f"a{c}_mps2"] for c in "xyz"]) if "ax_mps2" in d else None
    gyr = np.column_stack([d[f"g{c}_radps"] for c in "xyz"]) if "gx_radps" in d else None
    write(path, w.t if time else None, x, acc, gyr, cols)
    return about(w, expect="named", truth=[entry(e, s)], hidden=[entry(e, s)], columns=list(cols), recording=d.get("_name", ""))


def k_real_sphere(rng, split, path):
    d = real("hmc5883l-mpu6050-full-sphere")
    if rng.random() < .5:
        d = segment(rng, d, int(rng.integers(4500, 8000)))
    return inject(rng, split, d, path)


def k_real_tilt(rng, split, path):
    d = real(str(rng.choice(["hmc5883l-mpu6050-tilt-sphere", "hmc5883l-mpu6050-roll-and-tilt-at-45-90"])))
    return inject(rng, split, d, path)


def k_real_qmc(rng, split, path):
    d = real(str(rng.choice(["qmc5883l-filtered", "qmc5883l-noisy"])))
    d = {k: v[3200:] for k, v in d.items()}
    d = segment(rng, d, int(rng.integers(6000, 12000)))
    return inject(rng, split, d, path, unit=.0333, strengths=(1.5, 6), cap=.35)


def k_real_notime(rng, split, path):
    if rng.random() < .5:
        return inject(rng, split, real("hand-rotated-counts"), path, unit=.4, time=False, strengths=(2, 10), cap=.35)
    d = real("hmc5883l-mpu6050-full-sphere")
    d = {k: v for k, v in segment(rng, d, int(rng.integers(5000, 8190))).items()}
    return inject(rng, split, d, path, time=False)


def k_real_flight(rng, split, path):
    d = real("px4-quad-flight")
    on = np.flatnonzero(d["throttle_us"] > 50)
    d = {k: v[on[0]:on[-1]] for k, v in d.items()}
    if rng.random() < .5:
        d = segment(rng, d, 5000)
    what = str(rng.choice(["amp-offset", "temp2-offset", "step", "servo-offset"]))
    return inject(rng, split, d, path, strengths=(2, 8), what=what, cap=.5, least=1.0, calibrated=True)


def k_realdecoy(rng, split, path):
    """A recording as it is, with columns that have nothing to do with it."""
    names = ["hmc5883l-mpu6050-full-sphere", "hmc5883l-mpu6050-tilt-sphere", "hmc5883l-mpu6050-roll-and-tilt-at-45-90", "px4-quad-flight",
             "lsm9ds1-hand-outliers", "hand-rotated-counts", "imu-gnss-board", "qmc5883l-filtered", "qmc5883l-noisy"]
    name = str(rng.choice(names))
    d = real(name)
    if len(d[next(iter(d))]) > 9500:
        d = segment(rng, {k: v[3200:] for k, v in d.items()}, 8000)
    unit = {"qmc5883l-filtered": .0333, "qmc5883l-noisy": .0333, "hand-rotated-counts": .4, "imu-gnss-board": .1}.get(name, 1.0)
    w = RealWorld(rng, split, d, unit, True)
    t = w.clock
    pool = {"decoy_a": covs.current(rng, t), "decoy_c": covs.temperature(rng, t), "servo_deg": covs.servo(rng, t), "fan_rpm": covs.fan(rng, t),
            "mode": covs.mode(rng, t), "lamp_on": covs.switch(rng, t), "load_pct": 50 + covs.walk(rng, t, 9.), "vbat_v": covs.battery(rng, t), "rssi_db": covs.walk(rng, t, 4.)}
    keep = [str(k) for k in rng.permutation(list(pool))[:rng.integers(3, 7)]]
    cols = {k: pool[k] for k in pool if k in keep}
    decoys = list(cols)
    for k, v in d.items():
        if k.startswith(("motor", "throttle", "temp")):
            cols[k] = v
    acc = np.column_stack([d[f"a{c}_mps2"] for c in "xyz"]) if "ax_mps2" in d else None
    gyr = np.column_stack([d[f"g{c}_radps"] for c in "xyz"]) if "gx_radps" in d else None
    write(path, w.t, w.m, acc, gyr, cols)
    return about(w, expect="nodecoy", truth=[], hidden=[], decoys=decoys, columns=list(cols), recording=name)


def make(kind, split, index, path):
    rng = np.random.default_rng([{"dev": 41, "test": 7919}[split], zlib.crc32(kind.encode()), index])
    truth = globals()["k_" + kind.replace("-", "_")](rng, split, path)
    truth.update(kind=kind, split=split, index=index)
    with open(os.path.splitext(path)[0] + ".json", "w") as f:
        json.dump(truth, f, indent=1)
    return truth


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("kind", nargs="?")
    ap.add_argument("split", nargs="?")
    ap.add_argument("index", nargs="?", type=int)
    ap.add_argument("-o", dest="out")
    ap.add_argument("--all")
    ap.add_argument("-n", type=int, default=10)
    a = ap.parse_args()
    here = os.path.dirname(os.path.abspath(__file__))
    if a.all:
        for k in KINDS:
            os.makedirs(f"{here}/{a.all}/{k}", exist_ok=True)
            for i in range(a.n):
                p = f"{here}/{a.all}/{k}/{i:03}.csv"
                if not os.path.exists(p):
                    try:
                        make(k, a.all, i, p)
                    except Exception as e:
                        print(k, i, "not made:", repr(e), file=sys.stderr)
    else:
        print(json.dumps(make(a.kind, a.split, a.index, a.out), indent=1))


if __name__ == "__main__":
    main()
