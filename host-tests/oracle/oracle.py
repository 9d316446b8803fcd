#!/usr/bin/env python3
"""Oracle values for host-tests/tests/suite/oracle.rs, from an independent program (numpy, scipy).

    python3 host-tests/oracle/oracle.py > host-tests/oracle/oracle.json

Nothing here shares a formula's code with the crate: the designs are built row by row, the adjusted least squares is
solved by the smallest eigenvalue of the full noise-corrected matrix and a bracketing root finder, and the standard
errors come from the scatter of many simulated logs and from a numerical Jacobian of the residuals.
"""

import itertools
import json

import numpy as np
from scipy.optimize import brentq

SCALE = 1000.0  # counts in a field


def cases():
    """Truths in units of the field, noise, samples, part of the sphere."""
    paper = (
        np.array([0.5, 0.0, 0.75**0.5]),
        np.array([[0.64, 0.16, 0.25], [0.0, 0.62, 0.71], [0.0, 0.0, 0.79]]),
    )
    mild = (np.array([0.2, -0.1, 0.15]), np.array([[1.05, 0.06, -0.04], [0.0, 0.95, 0.03], [0.0, 0.0, 1.02]]))
    far = (np.array([3.0, -2.0, 2.5]), np.array([[0.9, -0.1, 0.05], [0.0, 1.1, 0.08], [0.0, 0.0, 1.0]]))
    return [
        ("paper", *paper, 0.02, 400, 1.0),
        ("mild", *mild, 0.01, 300, 1.0),
        ("far", *far, 0.01, 500, 1.0),
        ("half", *mild, 0.005, 600, 0.5),
        ("quarter", *mild, 0.005, 1500, 0.25),
    ]


def directions(rng, n, part):
    z = 1.0 - 2.0 * part * rng.random(n)
    angle = 2.0 * np.pi * rng.random(n)
    r = np.sqrt(1.0 - z * z)
    # A pole that is no axis.
    frame = np.linalg.qr(np.array([[1.0, 2.0, -1.0], [0.5, 1.0, 3.0], [2.0, -1.0, 0.3]]))[0]
    return np.stack([r * np.cos(angle), r * np.sin(angle), z], axis=1) @ frame


def samples(seed, b, a, sigma, n, part):
    rng = np.random.default_rng(seed)
    x = directions(rng, n, part) @ a.T + b + sigma * rng.standard_normal((n, 3))
    return np.rint(x * SCALE)


def calibration(m, g, k):
    """From x'Mx + g'x + k = 0 to the offset and the upper triangular C of a unit field."""
    b = -0.5 * np.linalg.solve(m, g)
    s = b @ m @ b - k
    q = m / s
    return b, np.linalg.cholesky(q).T


def constant(x):
    d = np.stack([x[:, 0] ** 2, x[:, 0], x[:, 1] ** 2, x[:, 1], x[:, 2] ** 2, x[:, 2],
                  x[:, 0] * x[:, 1], x[:, 2] * x[:, 1], x[:, 0] * x[:, 2]], axis=1)
    p = np.linalg.lstsq(d, np.ones(len(x)), rcond=None)[0]
    m = np.array([[p[0], p[6] / 2, p[8] / 2], [p[6] / 2, p[2], p[7] / 2], [p[8] / 2, p[7] / 2, p[4]]])
    return calibration(m, np.array([p[1], p[3], p[5]]), -1.0)


def trace(x):
    centre, unit = x.mean(axis=0), x.std()
    y = (x - centre) / unit
    px, py, pz = y.T
    d = np.stack([px**2 + py**2 - 2 * pz**2, px**2 + pz**2 - 2 * py**2, 2 * px * py, 2 * px * pz, 2 * py * pz,
                  2 * px, 2 * py, 2 * pz, np.ones(len(y))], axis=1)
    u = np.linalg.lstsq(d, (y**2).sum(axis=1), rcond=None)[0]
    m = np.array([[1 - u[0] - u[1], -u[2], -u[3]], [-u[2], 1 - u[0] + 2 * u[1], -u[4]],
                  [-u[3], -u[4], 1 + 2 * u[0] - u[1]]])
    b, c = calibration(m, -2 * u[5:8], -u[8])
    return centre + unit * b, c / unit


def hermite(v, power, s):
    return [np.ones_like(v), v, v**2 - s, v**3 - 3 * s * v, v**4 - 6 * s * v**2 + 3 * s * s][power]


def adjusted(x):
    """The null vector of the noise-corrected scatter matrix, at the noise where its least eigenvalue is zero."""
    centre, unit = x.mean(axis=0), x.std()
    y = (x - centre) / unit
    powers = [(2, 0, 0), (0, 2, 0), (0, 0, 2), (1, 1, 0), (1, 0, 1), (0, 1, 1), (1, 0, 0), (0, 1, 0), (0, 0, 1), (0, 0, 0)]

    def direct(s):
        table = np.array([[hermite(y[:, a], p, s) for p in range(5)] for a in range(3)])
        out = np.empty((10, 10))
        for i, j in itertools.combinations_with_replacement(range(10), 2):
            e = [p + q for p, q in zip(powers[i], powers[j])]
            out[i, j] = out[j, i] = np.mean(table[0, e[0]] * table[1, e[1]] * table[2, e[2]])
        return out

    # A polynomial of degree two in s: three evaluations are all of it.
    zero, plus, minus = direct(0.0), direct(1.0), direct(-1.0)

    def psi(s):
        return zero + s * (plus - minus) / 2 + s * s * ((plus + minus) / 2 - zero)

    top = np.linalg.eigvalsh(np.cov(y.T, bias=True))[0]
    s = brentq(lambda s: np.linalg.eigvalsh(psi(s))[0], 0.0, top, xtol=1e-18, rtol=1e-14)
    v = np.linalg.eigh(psi(s))[1][:, 0]
    if v[:3].sum() < 0:
        v = -v
    m = np.array([[v[0], v[3] / 2, v[4] / 2], [v[3] / 2, v[1], v[5] / 2], [v[4] / 2, v[5] / 2, v[2]]])
    b, c = calibration(m, v[6:9], v[9])
    n = len(x)
    return centre + unit * b, c / unit, unit * np.sqrt(s * n / (n - 9))


def nine(b, c):
    return np.concatenate([b, [c[0, 0], c[0, 1], c[0, 2], c[1, 1], c[1, 2], c[2, 2]]])


def main():
    out = []
    for name, b, a, sigma, n, part in cases():
        x = samples(1, b, a, sigma, n, part)
        found = {}
        for method, (bm, cm, *noise) in [("constant", constant(x)), ("trace", trace(x)), ("adjusted", adjusted(x))]:
            found[method] = {"offset": bm.tolist(), "matrix": cm.tolist()}
            if noise:
                found[method]["noise"] = noise[0]
        # Standard errors by brute force: the scatter of the adjusted solution over many logs.
        runs = np.array([nine(*adjusted(samples(1000 + i, b, a, sigma, n, part))[:2]) for i in range(200)])
        out.append({
            "name": name,
            "counts": x.astype(int).tolist(),
            "methods": found,
            "spread": runs.std(axis=0, ddof=1).tolist(),
        })
    print(json.dumps({"counts_per_field": SCALE, "cases": out}, separators=(",", ":")))


main()
