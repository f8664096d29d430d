"""python3 rank.py studies DIR writes the studies of ranking.json to DIR.
python3 rank.py FIRST.answer OTHER.answer ... ranks studies against the first one on the same seeds
(answers of `matrig --json study`). Of the last landing: ratio of the lift ratios (geometric mean
over the runways). Of all landings: largest movement of a mat, summed. 95 % intervals: bootstrap of
the runways; Wilson for the share of runways with a lift ratio below 1."""
import json
import math
import os
import random
import sys

RESAMPLES = 4000


def interval(values):
    draw = random.Random(1)
    means = sorted(sum(draw.choices(values, k=len(values))) / len(values) for _ in range(RESAMPLES))
    return sum(values) / len(values), means[RESAMPLES // 40], means[-RESAMPLES // 40 - 1]


def wilson(count, of, z=1.96):
    middle = (count / of + z * z / (2 * of)) / (1 + z * z / of)
    half = z * math.sqrt(count * (of - count) / of**3 + z * z / (4 * of * of)) / (1 + z * z / of)
    return 100 * (middle - half), 100 * (middle + half)


def write_studies(folder):
    here = os.path.dirname(os.path.abspath(__file__))
    with open(os.path.join(here, "ranking.json")) as file:
        ranking = json.load(file)
    for name, changes in ranking["modifications"].items():
        study = {**ranking["study"], **changes}
        study["landings"][0]["apply"] = study.pop("apply", {})
        for scene in "scene", "elastic":
            study[scene] = os.path.join(here, study[scene])
        with open(os.path.join(folder, name + ".json"), "w") as file:
            json.dump(study, file)


def landings(path):
    with open(path) as file:
        answer = json.load(file)
    if answer["failed"]:
        sys.exit(f"{path}: runways that failed: {answer['failed']}; repeat the study with a smaller step")
    return answer["name"], {run["seed"]: run["landings"] for run in answer["runways"]}


if sys.argv[1] == "studies":
    sys.exit(write_studies(sys.argv[2]))
first = landings(sys.argv[1])[1]
for path in sys.argv[1:]:
    name, runs = landings(path)
    seeds = sorted(runs.keys() & first.keys())
    flat = sum(runs[s][-1]["lift_ratio"] < 1 for s in seeds)
    lift = interval([math.log(runs[s][-1]["lift_ratio"] / first[s][-1]["lift_ratio"]) for s in seeds])
    moved = interval([sum(landing["peak_in"] for landing in runs[s]) for s in seeds])
    print(f"| {name} | {moved[0]:.2f} ({moved[1]:.2f} to {moved[2]:.2f}) |",
          "{:.2f} ({:.2f} to {:.2f}) |".format(*map(math.exp, lift)),
          "{} of {} ({:.0f} to {:.0f} %) |".format(flat, len(seeds), *wilson(flat, len(seeds))))
