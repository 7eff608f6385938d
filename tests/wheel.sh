#!/bin/sh
# Whether the Python module runs in a bare Debian 12 that has Python, an OpenCL driver and nothing else of ours:
#   sh setup.sh wheel && sh tests/wheel.sh [WHEEL]   from the wheel that was made
#   sh tests/wheel.sh .                              by pip install . of what is committed, as the chapter says
# Runs the four examples. As root, with debootstrap; see bare_debian.sh.
set -eu
cd "$(dirname "$0")/.."
wheel=${1:-$(ls -t build-wheel/brdfit-*manylinux*.whl 2>/dev/null | head -n 1)}
if [ ! -e "$wheel" ]; then
    echo "no wheel ${wheel:-in build-wheel}; sh setup.sh wheel makes one" >&2
    exit 2
fi

. tests/bare_debian.sh
mkdir "$root/brdfit"
git archive HEAD | tar -x -C "$root/brdfit"
if [ "$wheel" = . ]; then
    packages=$(sed -n '/^needed="/,/"$/p' setup.sh | tr -d '"' | sed 's/^needed=//')
    in_root apt-get install -q -y --no-install-recommends $packages python3-venv python3-dev
    what='.[frames,mitsuba]'
else
    in_root apt-get install -q -y --no-install-recommends pocl-opencl-icd python3-venv
    cp "$wheel" "$root/"
    what="/$(basename "$wheel")[frames,mitsuba]"
fi
in_root sh -c "cd /brdfit && python3 -m venv venv && venv/bin/pip install -q '$what'"
mkdir "$root/measured"
in_root sh -c 'cd /measured && cat >make.py' <<'MEASURED'
import sys
import numpy as np
import brdfit
material = brdfit.Material(diffuse=0.1, lobes=[{"model": "ggx", "ks": 0.5, "f0": 0.04, "a": 0.2}])
for name in sys.argv[1:]:
    rng = np.random.default_rng(1)
    wi, wo = rng.normal(size=(2, 2000, 3))
    wi[:, 2], wo[:, 2] = np.abs(wi[:, 2]), np.abs(wo[:, 2])
    wi /= np.linalg.norm(wi, axis=1)[:, None]
    wo /= np.linalg.norm(wo, axis=1)[:, None]
    brdfit.Samples(wi, wo, material.eval(wi, wo)).save(name)
MEASURED
in_root sh -c 'cd /measured && /brdfit/venv/bin/python make.py a.csv b.csv && rm make.py'
for example in fit_and_compare "database_to_frame /measured" table_for_a_renderer material_in_mitsuba; do
    set -- $example
    name=$1
    shift
    echo "== $name"
    in_root sh -c "mkdir -p /out && cd /out && /brdfit/venv/bin/python /brdfit/fit/python/examples/$name.py $*"
done
echo "$wheel installs and runs in a bare Debian 12"
