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

# Kurt, Szirmay-Kalos, Krivanek 2010: the exponent alpha of their model, and roughnesses alike and unlike.
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

# Materials designed with it, under a sky: of one lobe, and of lobes of unlike widths.
lobe() {
    echo "{\"model\": \"kurt\", \"ks\": $1, \"f0\": $2, \"mx\": $3, \"my\": $4, \"alpha\": $5}"
}
material plastic "[0.02, 0.1, 0.3]" "$(lobe '[1, 1, 1]' 0.04 0.05 0.05 0.2)"
material car-paint "[0.08, 0.005, 0.005]" "$(lobe '[1, 1, 1]' 0.04 0.01 0.01 0), $(lobe '[0.5, 0.08, 0.06]' 0.5 0.25 0.25 0.1)"
material copper "[0, 0, 0]" "$(lobe '[0.95, 0.64, 0.54]' 0.95 0.15 0.15 0.1)"
material steel "[0, 0, 0]" "$(lobe '[0.7, 0.7, 0.72]' 0.9 0.05 0.3 0)"
material satin "[0.1, 0.04, 0.08]" "$(lobe '[0.7, 0.4, 0.6]' 0.3 0.12 0.6 0.1)"
material matt "[0.3, 0.3, 0.25]" "$(lobe '[1, 1, 1]' 0.04 0.4 0.4 0.5)"
files=""
for name in plastic car-paint copper steel satin matt; do
    files="$files $out/$name.json"
done
picture kurt-materials $files --columns 3 --environment sky \
    --labels "plastic,paint of two lobes,copper,brushed steel,satin,matt with alpha 0.5"

# Ashikhmin, Premoze, Shirley 2000, Fig. 5: a golden Gaussian sphere beside Ward's of the same widths; satin, velvet,
# slanted velvet, and a Gaussian modulated by an image.
cp "$(dirname "$0")/letters.png" "$out"
distribution() {
    echo "$2" >"$out/$1-distribution.json"
    "$brdfit" generate --quiet "$out/$1-distribution.json" -o "$out/$1.exr" >"$out/$1.txt"
}
distribution gaussian '{"distribution": "gaussian", "sigma_x": 0.1, "sigma_y": 0.2}'
distribution satin '{"distribution": "satin"}'
distribution velvet '{"distribution": "velvet"}'
distribution slanted-velvet '{"distribution": "slanted-velvet"}'
distribution letters '{"distribution": "image", "image": "letters.png", "extent": 0.6, "base": {"distribution": "gaussian", "sigma": 0.5}}'
material golden "[0, 0, 0]" "{\"model\": \"microfacet\", \"ks\": $gold, \"f0\": 0.9, \"table\": \"gaussian.exr\"}"
material ward "[0, 0, 0]" "{\"model\": \"ward\", \"ks\": $gold, \"mx\": 0.1, \"my\": 0.2}"
picture golden-spheres "$out/golden.json" "$out/ward.json" --labels "generated,Ward" --environment softbox
material satin-cloth "[0.05, 0.01, 0.02]" '{"model": "microfacet", "ks": [0.9, 0.35, 0.4], "f0": 0.3, "table": "satin.exr"}'
material velvet-cloth "[0.05, 0.01, 0.02]" '{"model": "microfacet", "ks": [1, 0.25, 0.3], "f0": 0.6, "table": "velvet.exr", "correlated": true}'
material slanted-cloth "[0.05, 0.01, 0.02]" '{"model": "microfacet", "ks": [0.9, 0.2, 0.25], "f0": 0.3, "table": "slanted-velvet.exr"}'
material letters-metal "[0.02, 0.02, 0.03]" '{"model": "microfacet", "ks": [0.9, 0.9, 1], "f0": 0.6, "table": "letters.exr"}'
picture cloth-spheres "$out/satin-cloth.json" "$out/velvet-cloth.json" "$out/slanted-cloth.json" "$out/letters-metal.json" \
    --labels "satin,velvet,slanted velvet,image" --light directional:60,-110,3 --environment none --backdrop 0.02
