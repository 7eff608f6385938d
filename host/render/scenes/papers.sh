#!/bin/sh
# papers.sh FOLDER [BRDFIT]: the papers' pictures (see ../README.md), as PNG files in FOLDER.
# SIZE: pixels of a picture's side (default 256), SAMPLES: of a pixel (64).
set -eu
out=$1
brdfit=${2:-build/brdfit}
size=${SIZE:-256}
samples=${SAMPLES:-64}
mkdir -p "$out"

# material FILE KD LOBES
material() {
    echo "{\"brdfit\": 1, \"channels\": [\"R\", \"G\", \"B\"], \"diffuse\": {\"model\": \"lambert\", \"kd\": $2}, \"lobes\": [$3]}" >"$out/$1.json"
}
# picture NAME OPTION...
picture() {
    name=$1
    shift
    echo "$name"
    "$brdfit" render --quiet --size "$size" --samples "$samples" -o "$out/$name.png" "$@"
}
gold="[1, 0.77, 0.34]"

# Ashikhmin and Shirley 2000, Fig. 1: metallic spheres, nu to the right and nv downwards in 10, 100, 1000.
files="" labels=""
for nv in 10 100 1000; do
    for nu in 10 100 1000; do
        material "as-$nu-$nv" "[0, 0, 0]" "{\"model\": \"ashikhmin-shirley\", \"ks\": [1, 1, 1], \"f0\": 0.9, \"nu\": $nu, \"nv\": $nv}"
        files="$files $out/as-$nu-$nv.json"
        labels="$labels${labels:+,}nu $nu nv $nv"
    done
done
picture ashikhmin-shirley-spheres $files --columns 3 --labels "$labels" --environment softbox

# Fig. 2: a cylinder of brushed metal.
material brushed "[0, 0, 0]" '{"model": "ashikhmin-shirley", "ks": [0.95, 0.93, 0.88], "f0": 0.9, "nu": 10, "nv": 1000}'
for way in around along; do
    picture "ashikhmin-shirley-cylinder-$way" "$out/brushed.json" --labels "brushed $way" --brushed "$way" --shape cylinder \
        --view 65 --around -60 --environment softbox
done

# Kurt, Szirmay-Kalos, Krivanek 2010: the exponent alpha, and roughnesses of unlike size, of their model.
files="" labels=""
for alpha in 0 0.3 0.6; do
    for m in "0.1 0.1" "0.1 0.3" "0.3 0.1"; do
        name="kurt-$alpha-$(echo "$m" | tr ' ' '-')"
        material "$name" "[0.02, 0.02, 0.03]" "{\"model\": \"kurt\", \"ks\": [0.5, 0.5, 0.5], \"f0\": 0.6, \"mx\": ${m% *}, \"my\": ${m#* }, \"alpha\": $alpha}"
        files="$files $out/$name.json"
        labels="$labels${labels:+,}alpha $alpha m $m"
    done
done
picture kurt-spheres $files --columns 3 --labels "$labels" --environment softbox

# Ashikhmin, Premoze, Shirley 2000, Fig. 5: a golden Gaussian sphere beside Ward's of the same widths; satin, velvet and
# slanted velvet.
for cloth in gaussian satin velvet slanted-velvet; do
    widths=""
    [ "$cloth" != gaussian ] || widths=', "sigma_x": 0.1, "sigma_y": 0.2'
    echo "{\"distribution\": \"$cloth\"$widths}" >"$out/$cloth-distribution.json"
    "$brdfit" generate --quiet "$out/$cloth-distribution.json" -o "$out/$cloth.exr" >"$out/$cloth.txt"
done
material golden "[0, 0, 0]" "{\"model\": \"microfacet\", \"ks\": $gold, \"f0\": 0.9, \"table\": \"gaussian.exr\"}"
material ward "[0, 0, 0]" "{\"model\": \"ward\", \"ks\": $gold, \"mx\": 0.1, \"my\": 0.2}"
picture golden-spheres "$out/golden.json" "$out/ward.json" --labels "generated,Ward" --environment softbox
material satin-cloth "[0.05, 0.01, 0.02]" '{"model": "microfacet", "ks": [0.9, 0.35, 0.4], "f0": 0.3, "table": "satin.exr"}'
material velvet-cloth "[0.02, 0.005, 0.01]" '{"model": "microfacet", "ks": [0.9, 0.2, 0.25], "f0": 0.3, "table": "velvet.exr"}'
material slanted-cloth "[0.02, 0.005, 0.01]" '{"model": "microfacet", "ks": [0.9, 0.2, 0.25], "f0": 0.3, "table": "slanted-velvet.exr"}'
picture cloth-spheres "$out/satin-cloth.json" "$out/velvet-cloth.json" "$out/slanted-cloth.json" \
    --labels "satin,velvet,slanted velvet" --light directional:40,-120,3
