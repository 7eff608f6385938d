#pragma once

#include <cstdint>
#include <string>

// Small whole files of the formats that are read: what tests break and fuzzers begin with.

namespace brdfit::test {

inline const std::string csv_head = "theta_i,phi_i,theta_o,phi_o,R,G\n";
inline const std::string csv_example =
    csv_head + "0.5,0,0.25,3,0.1,0.2\n0.5,0,0.75,-1.5,-0.01,2e-2\n";
inline const std::string astm_example = "LAB_NAME A laboratory\nNUM_POINTS 2\n"
                                        "VARS theta_i,phi_i,theta_s,phi_s,R,G\n\n"
                                        "0.872665,0.0,0.573513,0.1,0.011364,-0.000779\n"
                                        "0.698132,0.0,0.427512,-0.2,0.012770,0.000718\n";
inline const std::string cornell_example =
    "# num wls\n3\n\n# wls\n400 450\n500\n\n# theta i, ...\n\n"
    "0.5 0.0 0.25 0.0 0.1 0.2 0.3\n0.6 0.0 0.35 1.0 0.5 0.6 0.7\n";
inline const std::string zemax_example =
    "# note\nSource\tMeasured\nSymmetry\tASymmetrical\nSpectralContent\tMonochrome\n"
    "ScatterType\tBRDF\nSampleRotation\t2\n0\t90\nAngleOfIncidence\t2\n15 30\n"
    "ScatterAzimuth\t3\n0 90 180\nScatterRadial\t3\n0 30 80\n\nMonochrome\nDataBegin\n"
    "TIS\t0.1\n1 0.5 0.25\n1 0.6 0\n1 0.7 0\nTIS\t0.2\n2 0.5 0.3\n2 0.6 0.3\n2 0 0\n"
    "3 0.5 0.3\n3 0.6 0.3\n3 0.1 0\n4 0.5 0.3\n4 0.6 0.3\n4 0 0\nDataEnd\n";
inline const std::string fred_example =
    "type bsdf_data\nformat angles=deg bsdf=value scale=2\n10\t0\n0\t0\t0.25\n5\t30\t0.125\n"
    "30\t0\n-20\t90\t0.5\n";
inline const std::string alta_example =
    "#SAMPLE \"x\"\n#DIM 3 1\n#VS 0\n#PARAM_IN ISOTROPIC_TL_TV_PROJ_DPHI\n"
    "#PARAM_OUT INV_STERADIAN_COSINE_FACTOR\n0.25 1.0 0.0 0.5\n0.25 -0.3 0.4 0.25\n"
    "0.5 1.5707963267948966 0 0.1\n";
/// A material with every part the format has.
inline const std::string material_example = R"({
        "brdfit": 1, "channels": ["R", "G", "B"],
        "diffuse": {"model": "lambert", "kd": [0.1, 0.2, 0.3]},
        "lobes": [{"model": "kurt", "ks": [0.5, 0.5, 0.5], "f0": 0.05, "mx": 0.2, "my": 0.3, "alpha": 0.1},
                  {"model": "ward", "ks": [0.25, 0, 1], "m": 0.2}],
        "fit": {"source": "a.binary", "error": {"ngan": 0.01}, "at_bound": ["f0"],
                "standard_errors": {"mx": 0.001}, "note": null}})";

/// A file with the bytes of one that NumPy writes: two pairs of directions.
inline std::string npy_example() {
    const std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 6), }\n";
    const float rows[12] = {0, 0, 1, 0.6F, 0, 0.8F, 0, 0, 1, 0, 1, 0};
    std::string bytes("\x93NUMPY\x01\x00", 8);
    bytes += {static_cast<char>(header.size()), '\0'};
    return bytes + header + std::string(reinterpret_cast<const char*>(rows), sizeof rows);
}

/// The bytes ahead of a MERL file's values.
inline std::string merl_header(std::int32_t a, std::int32_t b, std::int32_t c) {
    const std::int32_t dimensions[] = {a, b, c};
    return {reinterpret_cast<const char*>(dimensions), sizeof dimensions};
}

} // namespace brdfit::test
