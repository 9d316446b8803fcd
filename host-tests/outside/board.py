#!/usr/bin/env python3
"""Traces for the board core: 100 Hz, 60–120 s, one hidden effect, none, or a confounded pair.   board.py -n 12   writes board/KIND-NNN.csv and .json

LSM303DLHC-like: 1/1100 gauss a count (0.0909 µT), the chip's temperature in eighths of a degree, current fed from outside (current_a).
"""
import argparse, json, os, sys
import numpy as np
import gen, covs, motion
from gen import World, Offset, Step, Lag, Drift, logu, noise, write, entry

KINDS = {"temperature": 41, "current": 42, "lag": 43, "step": 44, "drift": 45, "clean": 46, "confounded": 47}


def make(kind, i, out):
    rng = np.random.default_rng([2026, KINDS[kind], i])
    hand = i % 4 == 3                                            # every fourth is waved by hand, the others turned about the board's own middle
    for _ in range(80):
        among = ["hand"] if hand else (["tumbling", "eights", "rings"])
        w = World(rng, "dev", among=among, T=rng.uniform(60, 120), rate=100.0, sigma=rng.uniform(.2, .5), colours=("white", "white", "ar"))
        if w.colour == "ar":
            w.par = float(rng.uniform(.3, .7))
        t = w.t
        amps = covs.current(rng, t)
        if kind == "confounded":
            temp = 22 + rng.uniform(3, 10) * t / w.T + .02 * rng.standard_normal(w.n)
        else:
            temp = covs.temperature(rng, t)
        cols = {"temp_c": temp, "current_a": amps}
        if kind != "confounded" and (gen.alike(cols, t, "temp_c") > .5 or gen.alike(cols, t, "current_a") > .5):
            continue
        e = {"temperature": lambda: Offset(rng, "temp_c", temp, t), "confounded": lambda: Offset(rng, "temp_c", temp, t),
             "current": lambda: Offset(rng, "current_a", amps, t), "lag": lambda: Lag(rng), "step": lambda: Step(rng, t),
             "drift": lambda: Drift(rng, t), "clean": lambda: None}[kind]()
        if e is None:
            a, s = 0, 0
            break
        a, s = w.scale(e, logu(rng, 2, 15))
        if s >= 1.7:
            break
    else:
        raise RuntimeError("not built")
    es = [e] if e else []
    x = w.measured(es, [a] if e else [])
    x = x + w.sigma * noise(rng, w.n, w.colour, w.par)
    lsb = 100 / 1100
    x = np.round(x / lsb) * lsb
    acc = np.round((w.spec + .03 * rng.standard_normal(w.spec.shape)) / .0098) * .0098
    gyr = np.round((w.om + .004 * rng.standard_normal(w.om.shape) + rng.uniform(-.008, .008, 3)) / .00015) * .00015
    write(out, t, x, acc, gyr, {"temp_c": np.round(temp * 8) / 8, "current_a": np.round(amps, 2)})
    truth = dict(kind=kind, index=i, motion=w.kind, hand=hand, rows=w.n, F=w.F, sigma=w.sigma, noise=w.colour, noise_par=w.par, A=w.A.tolist(), b=w.b.tolist(),
                 hidden=[entry(e, s)] if e else [], expect={"clean": "nothing is missing", "confounded": "confounded: offset:temp_c and drift"}.get(kind, e.id if e else ""),
                 per_unit=(a * e.d / np.ptp(np.asarray(temp if e.column == "temp_c" else amps))).tolist() if isinstance(e, Offset) else None,
                 delay_s=a if isinstance(e, Lag) else None, step_ut=(a * e.d).tolist() if isinstance(e, Step) else None)
    with open(out[:-3] + "json", "w") as f:
        json.dump(truth, f, indent=1)
    return truth


if __name__ == "__main__":
    ap = argparse.ArgumentParser()
    ap.add_argument("-n", type=int, default=12)
    a = ap.parse_args()
    here = os.path.dirname(os.path.abspath(__file__))
    os.makedirs(f"{here}/board", exist_ok=True)
    for k in KINDS:
        for i in range(a.n * (2 if k == "clean" else 1)):
            t = make(k, i, f"{here}/board/{k}-{i:03}.csv")
            print(k, i, t["motion"], t["noise"], [(h["id"], h["strength"], h.get("form")) for h in t["hidden"]], t["delay_s"], flush=True)
