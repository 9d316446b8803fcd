"""What changed between two saved runs:  cmp.py A.jsonl B.jsonl"""
import json, sys
a, b = ({(r["kind"], r["index"]): r for r in map(json.loads, open(p))} for p in sys.argv[1:3])
k = [x for x in a if x in b]
print(f"{len(k)} logs in both: deserved {sum(a[x]['good'] for x in k)} → {sum(b[x]['good'] for x in k)}; processor {sum(a[x]['cpu'] for x in k):.0f} → {sum(b[x]['cpu'] for x in k):.0f} s, worst {max(a[x]['cpu'] for x in k):.0f} → {max(b[x]['cpu'] for x in k):.0f}")
for x in k:
    if a[x]["good"] != b[x]["good"] or a[x]["named"] != b[x]["named"] or a[x]["verdict"] != b[x]["verdict"]:
        w = "better" if b[x]["good"] and not a[x]["good"] else "WORSE" if a[x]["good"] and not b[x]["good"] else "other"
        print(f"  {w} {x[0]}/{x[1]:03} {a[x]['noise']} {a[x]['rows']} hidden {a[x]['hidden']}: {a[x]['verdict']} {a[x]['named']} → {b[x]['verdict']} {b[x]['named']}{' conf ' + str(b[x]['conf']) if b[x]['conf'] else ''}")
