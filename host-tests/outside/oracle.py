#!/usr/bin/env python3
"""Is a log fair? Fits offset and matrix to it, and the same with the hidden effects' own shapes (as a tool would have them), on the magnitude.

  oracle.py LOG.csv ...     prints rms before, with the truth in the model, and the true sigma. Lag is not seen by the magnitude.
"""
import json, os, sys
import numpy as np
from scipy.optimize import least_squares


def load(p):
    with open(p) as f:
        h = f.readline().strip().split(",")
        a = np.array([[float(v) if v else np.nan for v in l.rstrip("\n").split(",")] for l in f])
    return {k: a[:, i] for i, k in enumerate(h)}


def shapes(d, m, e):
    i, n = e["id"].split("#")[0], len(m)
    eye = np.eye(3)
    def cov(c):
        v = d[c]
        ok = np.isfinite(v)
        v = np.interp(np.arange(n), np.flatnonzero(ok), v[ok])
        return v
    if i.startswith("offset:"):
        c = i[7:].split("^")[0].split("@")[0]
        v = cov(c)
        if i.endswith("^2"):
            v = v ** 2
        if "delay" in e:
            v = np.interp(d["t_s"] - e["delay"], d["t_s"], v)
        v = (v - v.mean()) / v.std()
        return [v[:, None] * eye[j] for j in range(3)]
    if i.startswith("gain:"):
        v = cov(i[5:]); v = (v - v.mean()) / v.std() / 50
        return [v[:, None] * m * eye[j] for j in range(3)]
    if i.startswith("field:"):
        v = cov(i[6:]); v = (v - v.mean()) / v.std() / 50
        return [("field", v)]
    if i == "drift":
        v = (d["t_s"] - d["t_s"].mean()) / d["t_s"].std()
        return [v[:, None] * eye[j] for j in range(3)]
    if i == "step":
        v = (d["t_s"] >= e["at"]).astype(float)
        return [v[:, None] * eye[j] for j in range(3)]
    if i == "periodic":
        t = d["t_s"]
        return [f(2 * np.pi * e["f"] * t)[:, None] * eye[j] for j in range(3) for f in (np.sin, np.cos)]
    if i == "nonlinearity":
        s = np.abs(m).max()
        return [(m / s) ** k * eye[j] for j in range(3) for k in (2, 3)]
    if i == "cross-axis":
        s = np.abs(m).max()
        return [(m[:, a] * m[:, b] / s ** 2)[:, None] * eye[j] for j in range(3) for a in range(3) for b in range(a, 3) if (a, b) != (j, j)]
    return []


def fit(d, m, effects):
    S = [x for e in effects for x in shapes(d, m, e)]
    add = [x for x in S if not isinstance(x, tuple)]
    fld = [x[1] for x in S if isinstance(x, tuple)]
    c, F = (m.max(0) + m.min(0)) / 2, np.median(np.linalg.norm(m - (m.max(0) + m.min(0)) / 2, axis=1))
    iu = np.triu_indices(3)
    step = max(1, len(m) // 6000)

    def fun(q):
        C = np.zeros((3, 3)); C[iu] = q[3:9]
        b = c + q[:3] * F
        v = m[::step] - b
        for k, x in enumerate(add):
            v = v - q[9 + k] * x[::step]
        r = np.linalg.norm(v @ C.T, axis=1)
        g = F
        for k, x in enumerate(fld):
            g = g * (1 + q[9 + len(add) + k] * x[::step])
        w = np.concatenate([(q[[3, 6, 8]] - 1) / .3, q[[4, 5, 7]] / .3]) * 1e-3
        return np.concatenate([(r - g), w])
    q0 = np.concatenate([np.zeros(3), np.eye(3)[iu], np.zeros(len(add) + len(fld))])
    s = least_squares(fun, q0, method="trf", x_scale="jac", max_nfev=60)
    return np.sqrt(np.mean(s.fun[:-6] ** 2))


for p in sys.argv[1:]:
    tr = json.load(open(os.path.splitext(p)[0] + ".json"))
    d = load(p)
    m = np.column_stack([d[f"m{a}_ut"] for a in "xyz"])
    h = tr["hidden"]
    try:
        r0, r1 = fit(d, m, []), fit(d, m, h)
        print(f"{p}: {tr['motion']} {tr['noise']} {len(m)} rows; {[(e['id'], e['strength']) for e in h]}: base {r0:.3f} with truth {r1:.3f} sigma {tr['sigma']:.3f} F {tr['F']:.1f}", flush=True)
    except Exception as x:
        print(p, repr(x))
