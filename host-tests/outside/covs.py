"""Columns that a log may carry: causes and decoys."""
import numpy as np
from motion import lowpass


def telegraph(rng, t, mean_s, levels):
    """Piecewise constant, at least five changes."""
    n_sw = max(6, int((t[-1] - t[0]) / mean_s))
    edges = np.sort(rng.uniform(t[0], t[-1], n_sw))
    lv = [rng.choice(levels)]
    for _ in range(n_sw):
        lv.append(rng.choice([x for x in levels if x != lv[-1]]))
    return np.array(lv)[np.searchsorted(edges, t)]


def smooth_edges(x, t, tau):
    """First-order approach (a motor does not jump)."""
    y, out = x[0], np.empty(len(x))
    dt = np.diff(t, prepend=t[0])
    for i in range(len(x)):
        y += (x[i] - y) * (1 - np.exp(-dt[i] / tau))
        out[i] = y
    return out


def fs_of(t):
    return (len(t) - 1) / (t[-1] - t[0])


def current(rng, t, thrust=None):
    top = rng.uniform(3, 25)
    if thrust is not None and rng.random() < .6:
        x = top * .4 * np.abs(thrust) ** 1.5
    else:
        k = rng.integers(0, 3)
        if k == 0:
            x = telegraph(rng, t, rng.uniform(3, 10), list(np.linspace(0, top, int(rng.integers(2, 6)))))
            x = smooth_edges(x.astype(float), t, rng.uniform(.02, .2))
        elif k == 1:
            x = top * np.clip(.5 + .25 * lowpass(rng, len(t), fs_of(t), rng.uniform(.05, .5)), 0, 1)
        else:
            x = telegraph(rng, t, rng.uniform(4, 12), [0., top, 0., .6 * top])
            x = smooth_edges(x, t, .1) * (1 + .15 * lowpass(rng, len(t), fs_of(t), .8))
    return x + .003 * top * rng.standard_normal(len(t))


def temperature(rng, t):
    T = t[-1] - t[0]
    s = (t - t[0]) / T
    span = rng.uniform(4, 25)
    k = rng.integers(0, 3)
    if k == 0:                                                      # warms up, then a fan is switched on
        x = 1 - np.exp(-s / rng.uniform(.1, .3))
        on = rng.uniform(.35, .6)
        x = np.where(s < on, x, x[np.searchsorted(s, on)] * (.25 + .75 * np.exp(-(s - on) / rng.uniform(.08, .2))))
    elif k == 1:                                                    # a hair dryer, twice
        x = sum(np.exp(-.5 * ((s - c) / w) ** 2) for c, w in zip(rng.uniform(.1, .9, 2), rng.uniform(.06, .15, 2)))
    else:
        x = .5 + .3 * lowpass(rng, len(t), fs_of(t), 2.5 / T)
    x = x + .02 * lowpass(rng, len(t), fs_of(t), min(.2, 20 / T))
    return np.round((rng.uniform(10, 30) + span * x + .02 * rng.standard_normal(len(t))) / .01) * .01


def walk(rng, t, scale=1.0):
    x = np.cumsum(rng.standard_normal(len(t)))
    return scale * (x - x.mean()) / (x.std() + 1e-12)


def mode(rng, t):
    return telegraph(rng, t, rng.uniform(5, 25), [0., 1., 2., 3., 5.])


def switch(rng, t):
    return telegraph(rng, t, rng.uniform(4, 30), [0., 1.])


def battery(rng, t, amps=None):
    s = (t - t[0]) / (t[-1] - t[0])
    v = rng.uniform(11.5, 16.8) - rng.uniform(.3, 1.5) * s - .3 * s ** 3
    if amps is not None:
        v = v - rng.uniform(.005, .02) * amps
    return np.round((v + .01 * rng.standard_normal(len(t))) / .01) * .01


def servo(rng, t):
    x = telegraph(rng, t, rng.uniform(2, 8), list(rng.uniform(-40, 40, 6)))
    return smooth_edges(x, t, .15) + .1 * rng.standard_normal(len(t))


def fan(rng, t):
    return smooth_edges(telegraph(rng, t, rng.uniform(5, 15), [0., 900., 1500., 2300.]), t, .8) + 4 * rng.standard_normal(len(t))


def height(rng, t):
    T = t[-1] - t[0]
    return rng.uniform(10, 80) * (.5 + .3 * lowpass(rng, len(t), fs_of(t), 2.5 / T)) + .05 * rng.standard_normal(len(t))


def wander(rng, t):
    """Slow noise of a made-up meaning (humidity, light, RSSI)."""
    return rng.uniform(1, 50) + rng.uniform(.5, 10) * lowpass(rng, len(t), fs_of(t), rng.uniform(.02, .4))


def correlated(rng, t, cause, rho):
    """A column that follows `cause` with correlation rho, the rest being structure of the same pace."""
    c = (cause - cause.mean()) / cause.std()
    # the cause's own spectrum with other phases keeps its pace
    f = np.fft.rfft(c)
    ph = rng.uniform(0, 2 * np.pi, len(f))
    other = np.fft.irfft(np.abs(f) * np.exp(1j * ph), len(c))
    other -= c * (other @ c) / (c @ c) + other.mean()
    other /= other.std()
    x = rho * c + np.sqrt(1 - rho ** 2) * other
    return rng.uniform(1, 40) * (x + rng.uniform(-2, 2))
