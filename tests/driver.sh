#!/bin/sh
# A chosen part of the tests on another OpenCL driver: values, derivatives, sums, samples, albedos, generator, a fit.
#   sh tests/driver.sh intel|rusticl [FORM]   FORM as for BRDFIT_FORM; run in the folder of the built tests
# Exit status: 0 passed, 77 the driver is not there (`sh setup.sh drivers` gets it).
set -eu
driver=$1
folder=$PWD/driver-$driver${2:+-$2}
rm -rf "$folder"
mkdir -p "$folder"
case "$driver" in
intel)
    library=$(find ../intel-opencl -name libintelocl.so 2>/dev/null | head -n 1)
    [ -n "$library" ] || {
        echo "skipped: Intel's CPU runtime (PyPI: intel-opencl-rt) is not there"
        exit 77
    }
    realpath "$library" >"$folder/intel.icd"
    ;;
rusticl)
    library=$(find ../rusticl-opencl -name libRusticlOpenCL.so.1 2>/dev/null | head -n 1)
    [ -n "$library" ] || {
        echo "skipped: Mesa's rusticl (Debian: mesa-opencl-icd) is not there"
        exit 77
    }
    realpath -s "$library" >"$folder/rusticl.icd"
    export RUSTICL_ENABLE=llvmpipe
    ;;
*)
    echo "$driver: unknown; expected intel or rusticl" >&2
    exit 2
    ;;
esac
export OCL_ICD_VENDORS="$folder" BRDFIT_TUNING="$folder/tuning.json" BRDFIT_FORM="${2:-}"
../brdfit devices -v
failed=0
chosen() {
    echo "== $1 on $driver${BRDFIT_FORM:+ in the form $BRDFIT_FORM}"
    # A filter that no test's name matches any more passes everywhere.
    "./$1" --gtest_list_tests --gtest_filter="$2" | grep -q '^ ' || failed=1
    "./$1" --gtest_brief=1 --gtest_filter="$2" || failed=1
}
chosen test_models 'Catalogue/EveryModel.equals_its_equation_*/kurt:Catalogue/EveryModel.equals_its_equation_*/ggx'
chosen test_objective '*.error_coefficients_and_gradient_are_those_of_float64/kurt_1_isotropic_3_channels'
chosen test_sampling '*EverySampler.follows_its_density/kurt:*EverySampler.estimates_the_albedo/kurt'
chosen test_albedo '*EveryAlbedo.agrees_with_quadrature/kurt'
chosen test_generator 'Generator.finds_reflectances_of_float64'
chosen test_fit '*EveryModel.is_recovered_from_noisy_data_on_merls_grid/kurt'
exit "$failed"
