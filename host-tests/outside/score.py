#!/usr/bin/env python3
"""Runs a build of ironout over one split and prints the table.

  score.py BINARY dev|test [-n N] [--kind K[,K]] [--no-fit] [--from I] [-j JOBS] [--save FILE]

`dev` reads (and makes) dev/KIND/NNN.csv; `test` makes each log in a private temporary folder and deletes it, and names no failures
beyond their kind. N is the number of logs a kind.
"""
import argparse, collections, json, os, resource, shutil, subprocess, sys, tempfile, threading, time
import numpy as np
import gen

HERE = os.path.dirname(os.path.abspath(__file__))
LIMIT = 120


def wilson(k, n, z=1.96):
    if n == 0:
        return "-"
    p = k / n
    c = (p + z * z / 2 / n) / (1 + z * z / n)
    h = z * np.sqrt(p * (1 - p) / n + z * z / 4 / n / n) / (1 + z * z / n)
    return f"{k}/{n} = {100 * p:.0f} % ({100 * max(0, c - h):.0f}–{100 * min(1, c + h):.0f})"


def run(cmd, limit=LIMIT):
    """(status, stdout, stderr, wall, cpu); status None after the limit."""
    t0 = time.monotonic()
    with tempfile.TemporaryFile() as o, tempfile.TemporaryFile() as e:
        p = subprocess.Popen(["nice", "-n", "10"] + cmd, stdout=o, stderr=e)
        killed = []
        timer = threading.Timer(limit, lambda: (killed.append(1), p.kill()))
        timer.start()
        _, st, ru = os.wait4(p.pid, 0)
        timer.cancel()
        p.returncode = os.waitstatus_to_exitcode(st)
        o.seek(0), e.seek(0)
        return (None if killed else p.returncode), o.read().decode(), e.read().decode(), time.monotonic() - t0, ru.ru_utime + ru.ru_stime


def base(i):
    return i.split("#")[0].split("@")[0].split("^")[0]


def match(named, truth):
    """(first right, exactly, the falsely named)"""
    left, wrong = list(truth), []
    for x in named:
        hit = next((t for t in left if base(x) in t["accept"]), None)
        if hit is None:
            wrong.append(x)
        else:
            left.remove(hit)
    first = bool(named) and any(base(named[0]) in t["accept"] for t in truth)
    return first, not left and not wrong and bool(truth), wrong


def read_csv(path):
    with open(path) as f:
        head = f.readline().strip().split(",")
        a = np.array([[float(v) if v else np.nan for v in l.rstrip("\n").split(",")] for l in f])
    return head, a


def unseen(binary, log, add, tmp, burst=None):
    """Rms of the corrected magnitude over its mean field on unseen blocks: base and with effects; words about refusal."""
    with open(log) as f:
        lines = f.readlines()
    head, rows = lines[0], lines[1:]
    n, k = len(rows), 10
    r = np.random.default_rng(len(rows))
    out = sorted(r.choice(np.arange(1, k - 1), 2, replace=False))
    hold = np.zeros(n, bool)
    for b in out:
        hold[n * b // k:n * (b + 1) // k] = True
    tr, te = f"{tmp}/train.csv", f"{tmp}/unseen.csv"
    open(tr, "w").writelines([head] + [l for l, h in zip(rows, hold) if not h])
    open(te, "w").writelines([head] + [l for l, h in zip(rows, hold) if h])
    st, o, e, *_ = run([binary, "fit", tr, "--json"], 60)
    try:
        b = json.loads(o)
        M, off, F = np.array(b["matrix"], float), np.array(b["offset_ut"], float), b["field_ut"]
        if M.shape != (3, 3):
            raise ValueError
    except Exception:
        return None, None, "no base fit"
    hd, a = read_csv(te)
    m = a[:, [hd.index(f"m{c}_ut") for c in "xyz"]]
    t = a[:, hd.index("t_s")] if "t_s" in hd else None
    keep = np.ones(len(m), bool)
    if t is not None:
        starts = [0] + list(np.flatnonzero(np.diff(t) > 5 * np.median(np.diff(t)) + 1e-9) + 1)
        for s in starts[:3]:
            keep &= ~((t >= t[s]) & (t < t[s] + 1.2))
    if burst and t is not None:                                     # a passing magnet is no error of the calibration
        keep &= np.abs(t - burst["at"]) > 6 * burst["width"]
    e0 = np.linalg.norm((m - off) @ M.T, axis=1) / F - 1
    cal = f"{tmp}/cal.json"
    if os.path.exists(cal):
        os.remove(cal)
    cmd = [binary, "fit", tr, "--json", "-o", cal]
    for x in add:
        cmd += ["--add", x]
    st, o, err, *_ = run(cmd, 90)
    if not os.path.exists(cal):
        return float(np.sqrt(np.mean(e0[keep] ** 2))), None, f"fit exit {st}"
    st, o, err, *_ = run([binary, "apply", te, "--cal", cal, "-o", f"{tmp}/o.csv", "--json"], 60)
    if st != 0:
        return None, None, f"apply exit {st}: {(o + err)[:120]}"
    hd, a = read_csv(f"{tmp}/o.csv")
    c = json.load(open(cal))
    e1 = a[:, hd.index("residual_ut")] / c["field_ut"]
    if len(e1) != len(e0):
        ok = np.isfinite(e1)
        return float(np.sqrt(np.mean(e0[keep] ** 2))), float(np.sqrt(np.nanmean(e1 ** 2))), ""
    ok = keep & np.isfinite(e1)
    return float(np.sqrt(np.mean(e0[ok] ** 2))), float(np.sqrt(np.mean(e1[ok] ** 2))), ""


def one(binary, log, truth, tmp, fit=True, text=False):
    r = dict(kind=truth["kind"], index=truth["index"], rows=truth["rows"], noise=truth["noise"], truth=[t["id"] for t in truth["truth"]],
             hidden=[(t["id"], t["strength"]) for t in truth["hidden"]])
    cmd = [binary, "diagnose", log, "--json"] + truth.get("args", [])
    if truth.get("prior"):
        pl = os.path.splitext(log)[0] + ".prior.csv"
        pc = f"{tmp}/prior.json"
        run([binary, "fit", pl, "-o", pc], 60)
        r["prior_ok"] = os.path.exists(pc)
        if r["prior_ok"]:
            cmd += ["--prior", pc]
    st, o, e, wall, cpu = run(cmd)
    r.update(status=st, wall=wall, cpu=cpu)
    try:
        d = json.loads(o)
    except Exception:
        d = {}
    if st is None or "verdict" not in d:
        r.update(verdict="timeout" if st is None else "error", named=[], first=False, exact=False, wrong=[], why=(o + e)[-300:], listed=[], conf=[])
        return r
    named = [s["added"] for s in d["steps"] if s["added"]]
    first, exact, wrong = match(named, truth["truth"])
    conf = [c["id"] for c in d["candidates"] if c["status"] == "confounded"]
    r.update(verdict=d["verdict"], named=named, first=first, exact=exact, wrong=wrong, conf=conf,
             listed=sorted(set(named + conf)), faults=[(f["kind"], f["from_s"], f["to_s"], f["samples"]) for f in d.get("data_faults", [])],
             floor=d.get("noise_floor_ut"), sigma=truth["sigma"],
             rms=[s["rms_ut"] for s in d["steps"]], hold=[s["holdout_rms_ut"] for s in d["steps"]])
    if text:
        s2, o2, *_ = run([binary, "diagnose", log])
        r["wayout"] = "--prior" in o2 or "through all" in o2
    if d["verdict"] in ("complete", "missing") and "axis-order" not in named and not truth.get("prior") and truth["kind"] != "level":
        cmd = [binary, "fit", log, "--json"] + sum((["--add", x] for x in named), [])
        s3, o3, e3, *_ = run(cmd, 90)
        r["fit_status"] = s3
        if s3 != 0:
            try:
                r["fit_reasons"] = json.loads(o3).get("reasons")
            except Exception:
                r["fit_reasons"] = (o3 + e3)[-200:]
    if fit and named and truth["kind"] not in ("level", "levelprior", "real-flight") and "axis-order" not in named:
        r["unseen"] = unseen(binary, log, named, tmp, truth.get("burst"))
    return r


def good(r, truth):
    """Did this log get the answer that its kind deserves?"""
    k, v = r["kind"], r["verdict"]
    if v in ("timeout", "error"):
        return False
    if k in ("none",) or (k in ("magnet", "journey") and not r["truth"]):
        return not r["named"]
    if k in ("deleted", "room"):
        return v not in ("complete", "missing")
    if k == "confounded":
        both = set(truth["both"])
        return v == "confounded" and both <= {base(x) for x in r["conf"]} and not r["wrong"]
    if k == "realdecoy":
        return not [x for x in r["named"] if any(base(x).endswith(":" + c) for c in truth["decoys"])]
    if k in ("level", "real-flight"):
        return (r["first"] and not r["wrong"]) or (v == "undetermined" and r.get("wayout", False))
    if k.startswith("real"):
        return r["first"]
    if k in ("decoy", "decoygap") and v == "confounded":
        return not r["wrong"] and any(base(x) in r["truth"] or base(x) in [base(t) for t in r["truth"]] for x in r["conf"])
    return r["exact"]


def line(r):
    t = " + ".join(f"{i} {s}×" for i, s in r["hidden"]) or "nothing"
    u = r.get("unseen")
    us = f" unseen {100 * u[0]:.2f}→{100 * u[1]:.2f} %" if u and u[0] and u[1] else (f" [{u[2]}]" if u else "")
    return (f"{r['kind']}/{r['index']:03} {r['rows']} rows {r['noise']}: hidden {t}; {r['verdict']} named {r['named']}"
            f"{' confounded ' + str(r['conf']) if r['conf'] else ''}{us} {r['wall']:.1f}s" + (f" ERROR {r['why']}" if r.get("why") else ""))


def table(rs):
    out = []
    by = collections.defaultdict(list)
    for r in rs:
        by[r["kind"]].append(r)

    def row(name, sub, cols):
        out.append(f"| {name} | {len(sub)} | " + " | ".join(cols) + " |")
    out.append("| kind | n | named first | exactly | something false named | verdicts | as deserved |")
    out.append("|---|---|---|---|---|---|---|")

    def std(name, sub):
        if not sub:
            return
        n = len(sub)
        v = collections.Counter(r["verdict"] for r in sub)
        row(name, sub, [wilson(sum(r["first"] for r in sub), n) if any(r["truth"] for r in sub) else "–",
                        wilson(sum(r["exact"] for r in sub), n) if any(r["truth"] for r in sub) else "–",
                        wilson(sum(bool(r["wrong"]) for r in sub), n), ", ".join(f"{a} {b}" for a, b in v.most_common()), wilson(sum(r["good"] for r in sub), n)])
    for k in gen.KINDS:
        sub = by.get(k, [])
        std(k, sub)
        if k in ("one", "none"):
            for c in ("white", "ar", "ma", "pink"):
                std(f"… {c}", [r for r in sub if r["noise"] == c])
        if k == "nl":
            for c in ("nonlinearity", "cross-axis"):
                std(f"… {c}", [r for r in sub if r["truth"] == [c]])
        if k in ("magnet", "journey"):
            std("… nothing hidden", [r for r in sub if not r["truth"]])
    out.append("")
    sub = by.get("deleted", [])
    if sub:
        out.append(f"cause deleted, `complete` or `missing` claimed: {wilson(sum(r['verdict'] in ('complete', 'missing') for r in sub), len(sub))}")
        out.append(f"cause deleted, floor over 1.5 × truth: {wilson(sum(bool(r.get('floor') and r['floor'] > 1.5 * r['sigma']) for r in sub), len(sub))}")
    sub = by.get("none", [])
    if sub:
        out.append(f"nothing hidden, `complete`: {wilson(sum(r['verdict'] == 'complete' for r in sub), len(sub))}")
    sub = [r for r in rs if r.get("fit_status") is not None]
    if sub:
        out.append(f"`complete` or `missing` said, but `fit` (with what was named) does not accept: {wilson(sum(r['fit_status'] != 0 for r in sub), len(sub))}")
    sub = by.get("realdecoy", [])
    if sub:
        out.append(f"recordings as they are, a decoy named: {wilson(sum(not r['good'] for r in sub), len(sub))}; named or listed: {wilson(sum(bool(r.get('decoy_listed')) for r in sub), len(sub))}")
    sub = [r for r in rs if r.get("unseen") and r["unseen"][0] and r["unseen"][1]]
    mag = [r for r in rs if r.get("burst_found") is not None]
    if mag:
        out.append(f"a magnet passes: reported as a burst at its time {wilson(sum(r['burst_found'] for r in mag), len(mag))}")
    if sub:
        q = np.array([r["unseen"][1] / r["unseen"][0] for r in sub])
        out.append(f"named, added, applied to unseen blocks: {len(sub)} fits accepted, median ratio {np.median(q):.2f}, falls in {wilson(int((q < 1).sum()), len(q))}, rises by > 5 % in {wilson(int((q > 1.05).sum()), len(q))}"
                   f" (effects in those: {sorted(collections.Counter(x for r, z in zip(sub, q) if z > 1.05 for x in r['named']).items())})")
        ref = [r for r in rs if r.get("unseen") and r["unseen"][1] is None]
        out.append(f"  the rest of those named: {len(ref)} not accepted ({dict(collections.Counter(r['unseen'][2] for r in ref))})")
    w, c = np.array([r["wall"] for r in rs]), np.array([r["cpu"] for r in rs])
    out.append(f"time of `diagnose`, wall (machine shared) median / 90 % / worst: {np.median(w):.1f} / {np.quantile(w, .9):.1f} / {w.max():.1f} s; processor {np.median(c):.1f} / {np.quantile(c, .9):.1f} / {c.max():.1f} s; "
               f"over {LIMIT} s: {sum(r['verdict'] == 'timeout' for r in rs)}; errors: {sum(r['verdict'] == 'error' for r in rs)}; rows {min(r['rows'] for r in rs)}–{max(r['rows'] for r in rs)}")
    return "\n".join(out)


def main():
    ap = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    ap.add_argument("binary")
    ap.add_argument("split", choices=["dev", "test"])
    ap.add_argument("-n", type=int, default=8)
    ap.add_argument("--from", dest="start", type=int, default=0)
    ap.add_argument("--kind", default=",".join(gen.KINDS))
    ap.add_argument("--no-fit", action="store_true")
    ap.add_argument("--save", help="all answers as JSON lines")
    a = ap.parse_args()
    binary = os.path.abspath(a.binary)
    rs = []
    priv = tempfile.mkdtemp(prefix="ho-")
    os.chmod(priv, 0o700)
    try:
        for i in range(a.start, a.start + a.n):
            for k in a.kind.split(","):
                tmp = tempfile.mkdtemp(dir=priv)
                try:
                    if a.split == "dev":
                        os.makedirs(f"{HERE}/dev/{k}", exist_ok=True)
                        log = f"{HERE}/dev/{k}/{i:03}.csv"
                        if not (os.path.exists(log) and os.path.exists(log[:-3] + "json")):
                            part = f"{tmp}/log.csv"
                            gen.make(k, "dev", i, part)
                            for f in os.listdir(tmp):
                                shutil.move(f"{tmp}/{f}", f"{HERE}/dev/{k}/{f.replace('log', f'{i:03}', 1)}")
                        truth = json.load(open(log[:-3] + "json"))
                    else:
                        log = f"{tmp}/log.csv"
                        truth = gen.make(k, "test", i, log)
                except Exception as e:
                    print(f"{k}/{i} not made: {e!r}", file=sys.stderr)
                    shutil.rmtree(tmp)
                    continue
                r = one(binary, log, truth, tmp, not a.no_fit, text=k in ("level", "real-flight"))
                r["good"] = good(r, truth)
                if "burst" in truth and "faults" in r:
                    r["burst_found"] = any(f[0] in ("burst", "clipping") and f[1] - 1 <= truth["burst"]["at"] <= f[2] + 1 for f in r["faults"])
                if "decoys" in truth:
                    r["decoy_listed"] = [x for x in r["listed"] if any(base(x).endswith(":" + c) for c in truth["decoys"])]
                rs.append(r)
                u = r.get("unseen")
                rises = bool(u and u[0] and u[1] and u[1] > 1.05 * u[0])
                if a.split == "dev" and (not r["good"] or rises):
                    print(("  FAIL " if not r["good"] else "  RISES ") + line(r), flush=True)
                if a.save:
                    with open(a.save, "a") as f:
                        f.write(json.dumps(r) + "\n")
                shutil.rmtree(tmp)
    finally:
        shutil.rmtree(priv, ignore_errors=True)
        if rs:
            print(table(rs))


if __name__ == "__main__":
    main()
