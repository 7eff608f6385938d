"""random_starts.py PROGRAM RESULTS.sqlite [FITS [STARTS]]: whether random starts beat fits of a run.

Draws FITS (300) of the finished fits that `PROGRAM merge` wrote to RESULTS.sqlite, the same ones every
time, and fits each again with STARTS (200) random starts besides the search. Prints those that a random
start beat by more than 0.1 % of the error; exit status 1 where there is one. Takes a second or two a
fit of a MERL file. The measured files must be where they were planned: call it where `plan` was."""

import hashlib
import json
import sqlite3
import subprocess
import sys
import tempfile


def drawn(results, count):
    fits = sqlite3.connect(f"file:{results}?mode=ro", uri=True).execute(
        "SELECT path, model, lobes, metric FROM fits WHERE state = 'done' AND lobes > 0").fetchall()
    return sorted(fits, key=lambda fit: hashlib.sha256(repr(fit).encode()).digest())[:count]


def fitted(program, fit, starts, folder):
    path, model, lobes, metric = fit
    command = [program, "--quiet", "fit", path, "-m", model, "--lobes", str(lobes), "--metric", metric,
               "--starts", str(starts), "-o", folder, "--force", "--json"]
    return json.loads(subprocess.run(command, check=True, capture_output=True).stdout)[0]


def main(program, results, count=300, starts=200):
    fits = drawn(results, int(count))
    beaten = 0
    with tempfile.TemporaryDirectory() as folder:
        for number, fit in enumerate(fits, 1):
            row = fitted(program, fit, starts, folder)
            beaten += row["random_starts_better"] > 0
            if row["random_starts_better"] > 0:
                print(*fit, f"beaten by {row['random_starts_better']} starts", flush=True)
            print(f"{number} of {len(fits)}, {beaten} beaten", file=sys.stderr, flush=True)
    print(f"{len(fits)} fits, {starts} random starts each: {beaten} were beaten by more than 0.1 %")
    return 1 if beaten or not fits else 0


if __name__ == "__main__":
    if not 3 <= len(sys.argv) <= 5:
        sys.exit(__doc__)
    sys.exit(main(*sys.argv[1:]))
