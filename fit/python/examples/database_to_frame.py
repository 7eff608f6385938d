"""Fits every file of a folder and makes one table of all results.

python database_to_frame.py FOLDER [MODELS]"""

from __future__ import annotations

import sys
from pathlib import Path

import pandas

import brdfit


def main(folder: str, models: str = "ward,ggx") -> pandas.DataFrame:
    frames = []
    for path in sorted(Path(folder).iterdir()):
        if path.suffix in (".binary", ".csv", ".npy", ".bsdf"):
            try:
                frames.append(brdfit.fit(path, models).to_frame())
            except brdfit.InputError as error:  # a broken file: the others go on
                print(error, file=sys.stderr)
    table = pandas.concat(frames, ignore_index=True)
    table["material"] = [Path(file).stem for file in table["file"]]
    print(table.pivot(index="material", columns="model", values="error_ngan"))
    best = table.loc[table.groupby("material")["error_ngan"].idxmin()]
    print(best["model"].value_counts())
    return table


if __name__ == "__main__":
    main(*sys.argv[1:3])
