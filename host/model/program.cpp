#include "host/model/program.hpp"

#include "host/device/kernels.hpp"

#include <algorithm>
#include <cctype>
#include <fmt/format.h>
#include <set>

namespace brdfit {

namespace {

int first_plane(const std::vector<PlacedModel>& placed, const Model* model) {
    return std::find_if(placed.begin(), placed.end(),
                        [&](const PlacedModel& p) { return p.model == model; })
        ->first_plane;
}

// The argument that hands a model its lobe's table: theta ends with each lobe's offset, tables
// follow (see device_parameters).
std::string table_argument(const Structure& structure, const Model& model, std::size_t lobe) {
    if (!model.table)
        return "";
    return fmt::format("theta + (int)theta[{}], ", layout_of(structure).parameters.size() + lobe);
}

// How the generated functions below call a model: one whose frame is turned as NAME_turned.
std::string called(const Model& model) {
    return model.identifier() + (model.turns ? "_turned" : "");
}

// A model of the structure's form with its frame turned by the last parameter, degrees: the planes
// are those of the directions.
std::string turned_model(const Model& model) {
    const std::string name = model.identifier();
    std::string planes = name;
    std::transform(planes.begin(), planes.end(), planes.begin(),
                   [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
    const std::size_t angle = model.anisotropic.size() - 1;
    return fmt::format(
        "static inline void {0}_turned_prepare(geometry q, real* plane)\n{{\n"
        "    write_geometry(q, plane);\n}}\n"
        "static inline real {0}_turned(const real* plane, PARAMETER_SPACE const float* theta, "
        "real* d)\n{{\n"
        "    const float angle = theta[{2}] * (PI / 180.0f);\n"
        "    const geometry q = turned(geometry_of(plane), cos(angle), sin(angle));\n"
        "    real own[{1}_PLANES];\n"
        "    {0}_prepare(q, own);\n"
        "    const real g = {0}(own, theta, d);\n"
        "    d[{2}] = g > 0.0f ? g * {0}_by_turn(q, theta) * (PI / 180.0f) : (real)(0.0f);\n"
        "    return g;\n}}\n"
        "static inline geometry {0}_turned_sample(vector wo, PARAMETER_SPACE const float* theta, "
        "real u1, real u2)\n{{\n"
        "    const float angle = theta[{2}] * (PI / 180.0f);\n"
        "    const float cosine = cos(angle), sine = sin(angle);\n"
        "    const vector own = {{cosine * wo.x + sine * wo.y, cosine * wo.y - sine * wo.x, "
        "wo.z}};\n"
        "    return turned({0}_sample(own, theta, u1, u2), cosine, -sine);\n}}\n"
        "static inline real {0}_turned_density(geometry q, PARAMETER_SPACE const float* "
        "theta)\n{{\n"
        "    const float angle = theta[{2}] * (PI / 180.0f);\n"
        "    return {0}_density(turned(q, cos(angle), sin(angle)), theta);\n}}\n",
        name, planes, angle);
}

// The part of the program that depends on the structure: macros and the two functions that run its
// models (see kernels/passes/evaluate.cl and kernels/passes/sums.cl).
std::string generated_text(const Structure& structure) {
    const StructureLayout layout = layout_of(structure);
    const std::vector<PlacedModel> placed = placed_models(structure);
    std::string bases;
    for (const DerivativeEntry& entry : layout.entries)
        bases += fmt::format("{}, ", entry.basis);
    std::string text = fmt::format("#line 1 \"generated\"\n"
                                   "#define BASIS {}\n#define ENTRIES {}\n#define PLANES {}\n"
                                   "#define PARAMETERS {}\n#define ENTRY_BASIS {{{}0}}\n",
                                   layout.basis, layout.entries.size(), layout.planes,
                                   parameter_stride(structure), bases);
    // The catalogue says how many planes the host makes room for, the kernel how many it fills.
    for (const PlacedModel& p : placed) {
        if (p.model->turns) {
            text += turned_model(*p.model);
            continue;
        }
        std::string macro = p.model->identifier();
        std::transform(macro.begin(), macro.end(), macro.begin(),
                       [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
        text += fmt::format("typedef char {}_fills_the_planes_of_the_catalogue[{}_PLANES == {} ? 1 "
                            ": -1];\n",
                            p.model->identifier(), macro, p.model->planes(structure.isotropic));
    }
    const bool lobes = !structure.lobes.empty();
    text += fmt::format("#define FRESNEL {}\n#define LAST_LOBE {}\n",
                        lobes && structure.lobes.back()->fresnel() ? 1 : 0,
                        lobes ? layout.lobe_begin[structure.lobes.size() - 1] : 0);
    text += "static inline void material_prepare(geometry q, real* plane)\n{\n";
    for (const PlacedModel& p : placed)
        text += fmt::format("    {}_prepare(q, plane + {});\n", called(*p.model), p.first_plane);
    text += "}\nstatic inline void material_basis(const real* plane, PARAMETER_SPACE const float* "
            "theta, real* b, real* d)\n{\n";
    const int diffuse_entry = layout.lobe_begin.back();
    text += fmt::format("    b[0] = {}(plane + {}, theta, {}d + {});\n",
                        structure.diffuse->identifier(), first_plane(placed, structure.diffuse),
                        table_argument(structure, *structure.diffuse, 0), diffuse_entry);
    for (std::size_t l = 0; l < structure.lobes.size(); ++l)
        text += fmt::format("    b[{}] = {}(plane + {}, theta + {}, {}d + {});\n", l + 1,
                            called(*structure.lobes[l]), first_plane(placed, structure.lobes[l]),
                            layout.lobe_begin[l], table_argument(structure, *structure.lobes[l], l),
                            layout.lobe_begin[l]);
    return text + "}\n";
}

// The functions that draw from a structure's components (see kernels/passes/sample.cl).
std::string generated_sampling(const Structure& structure) {
    const StructureLayout layout = layout_of(structure);
    std::string draw = "    if (j == 0)\n        return cosine_sample(wo, u1, u2);\n";
    std::string densities = "    p[0] = cosine_density(q);\n";
    for (std::size_t l = 0; l < structure.lobes.size(); ++l) {
        const std::string name = called(*structure.lobes[l]);
        const int begin = layout.lobe_begin[l];
        if (l + 1 < structure.lobes.size())
            draw += fmt::format("    if (j == {})\n    ", l + 1);
        std::string table = table_argument(structure, *structure.lobes[l], l);
        draw +=
            fmt::format("    return {}_sample(wo, theta + {}, {}u1, u2);\n", name, begin, table);
        if (!table.empty()) // the last argument
            table = ", " + table.substr(0, table.size() - 2);
        densities +=
            fmt::format("    p[{}] = {}_density(q, theta + {}{});\n", l + 1, name, begin, table);
    }
    if (structure.lobes.empty())
        draw = "    return cosine_sample(wo, u1, u2);\n";
    return "static inline geometry component_sample(int j, vector wo, PARAMETER_SPACE const float* "
           "theta, "
           "real u1, real u2)\n{\n" +
           draw +
           "}\nstatic inline void component_densities(geometry q, PARAMETER_SPACE const float* "
           "theta, "
           "real* p)\n{\n" +
           densities + "}\n";
}

// One of the variants of passes/sums.cl.
std::string sums_pass(const char* name, const char* with_gradient, const char* with_normal) {
    return kernel_variant(
        "passes/sums.cl",
        {{"NAME", name}, {"WITH_GRADIENT", with_gradient}, {"WITH_NORMAL", with_normal}});
}

// One of the variants of passes/loss.cl. (`log` alone cannot be a macro's value: it may be a
// macro.)
std::string loss_passes(const std::string& name) {
    const std::string compress = name + "_compress", loss = name + "_loss",
                      phi = "compressed_" + name, curvature = "curvature_" + name;
    return kernel_variant("passes/loss.cl", {{"COMPRESS", compress.c_str()},
                                             {"LOSS", loss.c_str()},
                                             {"PHI", phi.c_str()},
                                             {"CURVATURE", curvature.c_str()}});
}

// The structure's models and the functions that run them.
std::string model_text(const Structure& structure) {
    std::string text = fmt::format("#define ROUGHNESSES {}\n", structure.isotropic ? 1 : 2);
    if (structure.turns())
        text += "#define TURNED\n";
    if (structure.has_tables())
        text = "#define TABLES\n" + text;
    text += kernel_texts({"base/common.cl", "base/direction_planes.h", "base/geometry.cl",
                          "terms/schlick.cl", "terms/beckmann.cl", "terms/half_vectors.cl",
                          "terms/cosine_power.cl", "terms/trowbridge_reitz.cl", "terms/erf.cl"});
    if (structure.has_tables())
        text += kernel_texts({"terms/table_words.h", "terms/distribution.cl", "terms/grid.cl"});
    std::set<std::string> known; // a model may stand there turned too
    for (const PlacedModel& p : placed_models(structure))
        if (known.insert(p.model->name).second)
            text += kernel_text(fmt::format("models/{}.cl", p.model->name));
    return text + generated_text(structure);
}

} // namespace

cl::Program build_program(const Device& device, const Structure& structure, int channels,
                          int chunk) {
    std::string text = fmt::format("#define CHANNELS {}\n#define CHUNK {}\n", channels, chunk) +
                       model_text(structure) + kernel_text("passes/evaluate.cl");
    if (!structure.has_tables()) // what has tables is not fitted
        text += kernel_texts({"passes/prepare.h", "passes/prepare.cl", "passes/sums.h"}) +
                sums_pass("basis_sums", "0", "0") + sums_pass("gradient_sums", "1", "0") +
                sums_pass("normal_sums", "1", "1") + kernel_text("passes/residual.cl") +
                kernel_text("passes/compressions.cl") + loss_passes("log") + loss_passes("cbrt") +
                kernel_texts({"passes/metrics.cl", "passes/search.cl"});
    return build_kernels(device, text, structure.name());
}

cl::Program build_sample_program(const Device& device, const Structure& structure) {
    const std::string text = model_text(structure) + kernel_text("base/random.cl") +
                             generated_sampling(structure) +
                             kernel_texts({"passes/sample.h", "passes/sample.cl"});
    return build_kernels(device, text, structure.name());
}

cl::Program build_render_program(const Device& device, const Structure& structure) {
    const std::string text =
        model_text(structure) + kernel_text("base/random.cl") + generated_sampling(structure) +
        kernel_texts({"passes/sample.h", "passes/sample.cl", "scene/scene_words.h",
                      "scene/shapes.cl", "scene/lights.cl", "passes/render.cl",
                      "passes/render_measured.cl"});
    return build_kernels(device, text, structure.name());
}

cl::Program build_albedo_program(const Device& device, const Structure& structure) {
    const std::string text = model_text(structure) + kernel_text("base/random.cl") +
                             generated_sampling(structure) +
                             kernel_texts({"passes/albedo.h", "passes/albedo.cl"});
    return build_kernels(device, text, structure.name());
}

} // namespace brdfit
