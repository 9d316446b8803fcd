"""Attitudes and specific forces of hands, tables and aircraft. World NED, body x forward, y right, z down.

Quaternions (w,x,y,z) turn body vectors into the world. Everything lives on a fine, even grid of times.
"""
import numpy as np
from scipy.interpolate import CubicSpline
from scipy.signal import butter, sosfiltfilt
from scipy.spatial.transform import Rotation as Rot, Slerp

G = 9.80665


def lowpass(rng, n, fs, f, rms=1.0, dims=None):
    """Gaussian noise under `f` Hz with the given rms."""
    shape = (n,) if dims is None else (n, dims)
    f = min(f, 0.4 * fs)
    pad = int(3 * fs / f) + 8
    w = rng.standard_normal((n + 2 * pad,) + shape[1:])
    y = sosfiltfilt(butter(2, f, fs=fs, output="sos"), w, axis=0)[pad:pad + n]
    return rms * y / (y.std(axis=0) + 1e-12)


def integrate(omega, dt, q0=None):
    """Rotations from body rates (n×3)."""
    n = len(omega)
    d = Rot.from_rotvec(omega * dt).as_quat()
    x, y, z, w = q0.as_quat() if q0 is not None else (0.0, 0.0, 0.0, 1.0)
    out = np.empty((n, 4))
    for i in range(n):
        out[i] = x, y, z, w
        bx, by, bz, bw = d[i]
        x, y, z, w = (w * bx + x * bw + y * bz - z * by, w * by - x * bz + y * bw + z * bx,
                      w * bz + x * by - y * bx + z * bw, w * bw - x * bx - y * by - z * bz)
    return Rot.from_quat(out)


def rates(R, dt):
    d = (R[:-1].inv() * R[1:]).as_rotvec() / dt
    return np.vstack([d, d[-1:]])


def keyframes(times, rots, t):
    """Smooth stop-and-go between held attitudes: times are pairs (arrive, leave)."""
    kt, kr = [], []
    for (a, b), r in zip(times, rots):
        kt += [a, b]
        kr += [r, r]
    kt = np.array(kt)
    s = np.clip(np.searchsorted(kt, t, side="right") - 1, 0, len(kt) - 2)
    u = np.clip((t - kt[s]) / np.maximum(kt[s + 1] - kt[s], 1e-9), 0, 1)
    u = u * u * u * (10 - 15 * u + 6 * u * u)
    warped = s + u
    return Slerp(np.arange(len(kt)), Rot.concatenate(kr))(warped)


def tumbling(rng, t, fs, p):
    n = len(t)
    om = lowpass(rng, n, fs, rng.uniform(.12, .5), p["turn"] * rng.uniform(.4, 1.3), 3)
    om += lowpass(rng, n, fs, 0.03, .25 * p["turn"], 3)
    R = integrate(om, 1 / fs, Rot.random(random_state=rng))
    return R, lowpass(rng, n, fs, 1.0, rng.uniform(.05, .6), 3)


def eights(rng, t, fs, p):
    n, w = len(t), 2 * np.pi * rng.uniform(.25, .6) * min(1.5, p["turn"])
    ph = w * t + np.cumsum(lowpass(rng, n, fs, .2, .15, None)) / fs * w
    turns = rng.integers(2, 6)
    yaw = 2 * np.pi * turns * t / t[-1] + .9 * np.sin(ph) + lowpass(rng, n, fs, .1, .3)
    pitch = rng.uniform(.7, 1.2) * np.sin(2 * ph + .4) + lowpass(rng, n, fs, .08, .5)
    roll = rng.uniform(.8, 1.5) * np.sin(ph + 1.1) + lowpass(rng, n, fs, .05, 1.4)
    R = Rot.from_euler("ZYX", np.c_[yaw, pitch, roll])
    a = rng.uniform(.5, 2.5)
    acc = np.c_[a * np.sin(ph), .7 * a * np.sin(2 * ph + .4), .2 * a * np.cos(2 * ph)] + lowpass(rng, n, fs, 1., .2, 3)
    return R, acc


def hand(rng, t, fs, p):
    n, times, rots, now = len(t), [], [], 0.0
    base = Rot.random(random_state=rng)
    while now < t[-1] + 5:
        hold = rng.uniform(.3, 2.5)
        times.append((now, now + hold))
        rots.append(base)
        now += hold + rng.uniform(.6, 1.8) / p["turn"]
        base = base * Rot.from_rotvec(rng.standard_normal(3) * 1.3)
    R = keyframes(times, rots, t)
    wob = lowpass(rng, n, fs, rng.uniform(.6, 2.0), rng.uniform(.1, .35), 3)
    return R * Rot.from_rotvec(wob), lowpass(rng, n, fs, rng.uniform(.8, 2.5), rng.uniform(.5, 2.5), 3)


def table(rng, t, fs, p):
    n = len(t)
    faces = [Rot.from_euler("ZYX", e, degrees=True) for e in
             ([0, 0, 0], [0, 0, 180], [0, 0, 90], [0, 0, -90], [0, 90, 0], [0, -90, 0])]
    extra = [Rot.from_euler("ZYX", [0, rng.uniform(-60, 60), rng.uniform(-180, 180)], degrees=True) for _ in range(6)]
    faces = [faces[i] for i in rng.permutation(6)] + extra
    rng.shuffle(faces)
    per = max(t[-1] / len(faces), 3.0)
    times, rots, now, yaw, k = [], [], 0.0, rng.uniform(0, 6.28), 0
    while now < t[-1] + 5:
        f = faces[k % len(faces)]
        k += 1
        stops = rng.integers(3, 6)
        for _ in range(stops):
            hold = rng.uniform(.15, .5) * per / stops
            times.append((now, now + hold))
            rots.append(Rot.from_euler("Z", yaw) * f)
            now += hold + .55 * per / stops
            yaw += 2 * np.pi / stops * rng.uniform(.8, 1.2)
    return keyframes(times, rots, t), lowpass(rng, n, fs, 1., rng.uniform(.005, .05), 3)


def rings(rng, t, fs, p):
    n, m = len(t), int(rng.integers(4, 9))
    edges = np.linspace(0, t[-1] + 1e-6, m + 1)
    turns = rng.integers(1, 4)
    R = None
    pieces = []
    mount = Rot.random(random_state=rng)
    for k in range(m):
        s = (t >= edges[k]) & (t < edges[k + 1])
        x = (t[s] - edges[k]) / (edges[k + 1] - edges[k])
        ang = 2 * np.pi * turns * x + .08 * np.sin(9 * x)
        heading = Rot.from_euler("Z", k * np.pi / m + rng.uniform(-.15, .15))
        about = Rot.from_rotvec(np.outer(ang, [0, 1, 0]))          # about a horizontal axis
        tilt = Rot.from_euler("X", rng.uniform(-.9, .9) if k % 2 else 0.0)
        pieces.append(heading * tilt * about * mount)
    R = Rot.concatenate(pieces)
    wob = lowpass(rng, n, fs, .5, rng.uniform(.01, .08), 3)
    return R * Rot.from_rotvec(wob), lowpass(rng, n, fs, 1., rng.uniform(.02, .4), 3)


def acro(rng, t, fs, p):
    """A quadrotor that rolls and flips. The accelerometer feels thrust and drag, not gravity."""
    n = len(t)
    tilt = lowpass(rng, n, fs, .25, .35, 2)
    yaw = np.cumsum(lowpass(rng, n, fs, .15, rng.uniform(.4, 1.0))) / fs
    prof = np.zeros((n, 3))
    thrust = np.ones(n)
    now = rng.uniform(1, 4)
    while now < t[-1] - 3:
        dur = rng.uniform(.8, 2.2)
        axis = int(rng.integers(0, 2))
        amount = rng.choice([1, 1, -1, -1, .5, -.5])
        x = np.clip((t - now) / dur, 0, 1)
        s = x * x * (3 - 2 * x)
        if abs(amount) == .5:                                       # stays on its back for a while
            stay = rng.uniform(.3, 1.0)
            y = np.clip((t - now - dur - stay) / dur, 0, 1)
            prof[:, axis] += 2 * np.pi * amount * (s + y * y * (3 - 2 * y))
            now += dur + stay
        else:
            prof[:, axis] += 2 * np.pi * amount * s
        thrust[(x > 0) & (x < 1)] *= rng.uniform(.2, .6)
        k = np.clip((t - now - dur) / .8, 0, 1)
        thrust += .8 * np.sin(np.pi * k)
        now += dur + rng.uniform(1.2, 5)
    R = Rot.from_euler("Z", yaw[:, None]) * Rot.from_euler("YX", tilt) * Rot.from_euler("XY", prof[:, :2])
    force = np.maximum(thrust + lowpass(rng, n, fs, 1.2, .12), .05) * G
    drag = lowpass(rng, n, fs, .3, .8, 2)
    spec = np.c_[drag, -force]
    return R, ("specific", spec)


def level(rng, t, fs, p):
    """A survey flight or a drive: any heading, little tilt."""
    n = len(t)
    a = p.get("tilt", .15)
    yaw = 2 * np.pi * rng.integers(2, 6) * t / t[-1] + lowpass(rng, n, fs, .05, .7)
    tilt = lowpass(rng, n, fs, .3, a, 2)
    R = Rot.from_euler("ZYX", np.c_[yaw, tilt])
    spec = np.c_[lowpass(rng, n, fs, .3, .3, 2), -G * (1 + lowpass(rng, n, fs, .5, .05))]
    return R, ("specific", spec)


MOTIONS = dict(tumbling=tumbling, eights=eights, hand=hand, table=table, rings=rings, acro=acro, level=level)


def run(kind, rng, t, fs, p):
    """Rotation, body rates, specific force in the body, thrust signal (1 = hover) on the fine grid."""
    R, acc = MOTIONS[kind](rng, t, fs, p)
    om = rates(R, 1 / fs)
    if isinstance(acc, tuple):
        f = acc[1]
    else:
        f = R.inv().apply(acc - np.array([0, 0, G]))
    return R, om, f
