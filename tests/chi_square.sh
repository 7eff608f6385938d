#!/bin/sh
# Whether what `brdfit sample` draws follows what `brdfit pdf` says, by chi-square on their own output:
#   sh tests/chi_square.sh MATERIAL.json [THETA,PHI [N]]
# The hemisphere is cut in 16 x 48 cells of equal solid angle; those with few samples count as one, and
# so do the rejected samples. Fails where the statistic is 6 standard deviations off.
# BRDFIT: the program, build/brdfit where it is not set.
set -eu
brdfit=${BRDFIT:-build/brdfit}
material=$1
viewer=${2:-60,30}
count=${3:-200000}
folder=$(mktemp -d)
trap 'rm -rf "$folder"' EXIT

# 20 x 20 directions a cell, to integrate the density over it.
awk -v viewer="$viewer" 'BEGIN {
    split(viewer, angle, ","); degree = atan2(0, -1) / 180; t = angle[1] * degree; p = angle[2] * degree
    print "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z"
    for (i = 0; i < 320; ++i) for (j = 0; j < 960; ++j) {
        z = (i + 0.5) / 320; r = sqrt(1 - z * z); phi = (j + 0.5) * 360 / 960 * degree
        printf "%.8f,%.8f,%.8f,%.8f,%.8f,%.8f\n", r * cos(phi), r * sin(phi), z,
               sin(t) * cos(p), sin(t) * sin(p), cos(t)
    } }' >"$folder/grid.csv"
"$brdfit" sample "$material" --wo "$viewer" -n "$count" --sequence philox -o "$folder/samples.csv"
"$brdfit" pdf "$material" "$folder/grid.csv" -o "$folder/density.csv"

awk -F, -v count="$count" '
    function cell(x, y, z,  turn) {
        turn = atan2(y, x) / (2 * atan2(0, -1)); if (turn < 0) turn += 1
        return int(z * 16 < 16 ? z * 16 : 15) * 48 + int(turn * 48) % 48
    }
    /^#/ || /^[a-z]/ { next }
    FILENAME ~ /samples/ { if ($4 > 0) ++seen[cell($1, $2, $3)]; else ++seen["rejected"]; next }
    {
        k = int(n / 960); j = n % 960; ++n
        expected[int(k / 20) * 48 + int(j / 20)] += $1 * 2 * atan2(0, -1) / (320 * 960) * count
        total += $1 * 2 * atan2(0, -1) / (320 * 960) * count
    }
    END {
        expected["rejected"] = count - total
        for (c in expected) {
            if (expected[c] < 20) { few += expected[c]; few_seen += seen[c]; continue }
            chi2 += (seen[c] - expected[c]) ^ 2 / expected[c]; ++cells
        }
        if (few > 5) { chi2 += (few_seen - few) ^ 2 / few; ++cells }
        printf "%d samples in %d cells: chi-square %.1f, expected %d +- %.1f\n",
               count, cells, chi2, cells - 1, sqrt(2 * (cells - 1))
        exit !(cells > 10 && (chi2 - cells + 1) ^ 2 < 36 * 2 * (cells - 1))
    }' "$folder/samples.csv" "$folder/density.csv"
