"""The table of saved answers; later files replace earlier rows:  tab.py A.jsonl B.jsonl"""
import json, sys
import score
d = {}
for p in sys.argv[1:]:
    for l in open(p):
        r = json.loads(l)
        d[r["kind"], r["index"]] = r
print(f"n = {len(d)} logs\n")
print(score.table(list(d.values())))
