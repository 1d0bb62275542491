#!/usr/bin/env python3
"""How forecasts of the second campaign of each pair come true: the table of `scripts/blind loop`.

    python3 scripts/blind_generator.py --out DIR --seed 7 --count 100 --pairs
    python3 scripts/blind_loop.py GYROWATCH DIR
    python3 scripts/blind_loop.py GYROWATCH DIR --alarms

For each pair (chain): `model fit` of the first campaign (all but the last) with the effects that its diagnosis names, the same without effects, `predict`
of the second, and `calibrate --model` of both for D_I and D_S at the model's temperature. With --alarms only what the rule
`forecast` says, by kind of pair.
"""

import json
import math
import pathlib
import subprocess
import sys


def run(*arguments):
    done = subprocess.run([str(a) for a in arguments], capture_output=True, text=True)
    if done.returncode:
        raise RuntimeError(f"{arguments}: {done.stderr}")
    return done.stdout


def drift(answer):
    return {(s["slot"], d): (s[d]["value"], s[d]["sd"]) for s in answer["separations"] for d in ("d_i", "d_s")}


def kolmogorov(values):
    values, n = sorted(values), len(values)
    away = max(max((i + 1) / n - v, v - i / n) for i, v in enumerate(values))
    x = (math.sqrt(n) + 0.12 + 0.11 / math.sqrt(n)) * away
    return 1.0 if x < 0.3 else min(1.0, sum(2 * (-1) ** (k - 1) * math.exp(-2 * k * k * x * x) for k in range(1, 100)))


def share(hits):
    return f"{sum(hits)}/{len(hits)}" + (f" ({100 * sum(hits) / len(hits):.1f} %)" if hits else "")


def before(folder, name, entry):
    return [folder / one for one in [name, *entry["between"]]]


def foretold(gyrowatch, folder, name, entry):
    model, second = folder / "model.json", folder / entry["next"]
    run(gyrowatch, "model", "fit", *before(folder, name, entry), "-o", model)
    return json.loads(run(gyrowatch, "predict", model, second, "--format", "json"))


def alarms(gyrowatch, folder, key):
    kinds, ps = {}, []
    for name, entry in key.items():
        compared = foretold(gyrowatch, folder, name, entry)["compared"]
        kinds.setdefault(entry["kind"], []).append(compared["verdict"]["state"])
        if entry["kind"] == "clean":
            ps.append(compared["p_value"])
    for kind, states in kinds.items():
        of = lambda state: share([s == state for s in states])
        print(f"{kind:12} exceeded {of('exceeded')}, within {of('within')}, indeterminate {of('indeterminate')}")
    if ps:
        print(f"Kolmogorov over the p of clean pairs: {kolmogorov(ps):.3f}")


def one(gyrowatch, folder, name, entry):
    model, plain = folder / "model.json", folder / "plain.json"
    first, second = folder / name, folder / entry["next"]
    told = foretold(gyrowatch, folder, name, entry)
    run(gyrowatch, "model", "fit", *before(folder, name, entry), "--effects", "none", "-o", plain)
    bare = json.loads(run(gyrowatch, "predict", plain, second, "--format", "json"))
    then, now = (drift(json.loads(run(gyrowatch, "calibrate", c, "--model", model, "--format", "json")))
                 for c in (first, second))
    steps = [abs(now[k][0] - then[k][0]) / math.hypot(now[k][1], then[k][1]) for k in then if now[k][1] and then[k][1]]
    return told, bare, steps


def main():
    gyrowatch, folder = sys.argv[1], pathlib.Path(sys.argv[2])
    key = json.loads((folder / "key.json").read_text())
    if "--alarms" in sys.argv:
        return alarms(gyrowatch, folder, key)
    rows, skipped = [], 0
    for name, entry in key.items():
        try:
            rows.append((entry, *one(gyrowatch, folder, name, entry)))
        except RuntimeError as why:
            skipped += 1
            print(why, file=sys.stderr)
    steady = [row for row in rows if row[0]["kind"] != "tripled"]
    for kind in ("clean", "same", "warmer"):
        some = sorted((row[1]["compared"]["rms_over_sd"], row[2]["compared"]["rms_over_sd"])
                      for row in steady if row[0]["kind"] == kind)
        if some:
            rms, bare = [a for a, _ in some], sorted(b for _, b in some)
            print(f"{kind:8} rms/sd median {rms[len(rms) // 2]:.3f}, 90 % {rms[int(0.9 * len(rms))]:.3f}; "
                  f"without effects {bare[len(bare) // 2]:.2f}, 90 % {bare[int(0.9 * len(bare))]:.2f}")
    print("rms/sd at most 1.15:", share([row[1]["compared"]["rms_over_sd"] <= 1.15 for row in steady]))
    # One number a pair, which should be uniform: the chance of errors as large.
    print(f"Kolmogorov over the p of all pairs: {kolmogorov([row[1]['compared']['p_value'] for row in steady]):.3f}")
    pits = [row[1]["compared"]["pit_p_value"] for row in steady]
    print(f"Kolmogorov over the PIT p of all pairs: {kolmogorov(pits):.3f}")
    said = lambda row: any(e["changed"] for e in (row[1].get("effects_against_model") or {"effects": []})["effects"])
    print("tripled coefficient said:", share([said(row) for row in rows if row[0]["kind"] == "tripled"]))
    print("said where nothing changed:", share([said(row) for row in steady]))
    closings = [(row[1]["promised"], row[1]["compared"]["closing"]) for row in steady if row[1].get("promised")]
    inside = [p["interval"][0] <= c["closure"] <= p["interval"][1] + 1e-9 for p, c in closings if p["interval"]]
    print("closure seen inside the interval promised:", share(inside))
    steps = [max(row[3]) for row in steady if row[3]]
    print("largest step of D_I, D_S at most 3 sd:", share([s <= 3 for s in steps]))
    every = [s for row in steady for s in row[3]]
    print("steps of D_I and D_S one by one at most 3 sd:", share([s <= 3 for s in every]))
    if skipped:
        print(f"refused: {skipped}")
    if "-v" in sys.argv:
        for entry, told, bare, steps in rows:
            c = told["compared"]
            print(entry["kind"], entry["effects"], told["model"]["effects"], entry["sem"], entry["design"],
                  f"{c['rms_over_sd']:.3f} {c['p_value']:.3f} pit {c['pit_p_value']:.3f} bare "
                  f"{bare['compared']['rms_over_sd']:.2f} promised {told.get('promised')} seen {c.get('closing')} "
                  f"step {max(steps, default=0):.2f} {[e for e in (told.get('effects_against_model') or {'effects': []})['effects'] if e['changed']]}")


if __name__ == "__main__":
    main()
