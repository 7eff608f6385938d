#include "host/device/program.hpp"

#include "host/embedded.hpp"
#include "host/error.hpp"
#include "host/file.hpp"

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <fmt/format.h>

namespace brdfit {

namespace {

// The distinct models of a structure, each with its first plane.
struct PlacedModel {
    const Model* model;
    int first_plane;
};

std::vector<PlacedModel> placed_models(const Structure& structure) {
    std::vector<PlacedModel> placed;
    int planes = 0;
    const auto place = [&](const Model* model) {
        const bool known = std::any_of(placed.begin(), placed.end(),
                                       [&](const PlacedModel& p) { return p.model == model; });
        if (known)
            return;
        placed.push_back({model, planes});
        planes += model->planes(structure.isotropic);
    };
    place(structure.diffuse);
    for (const Model* lobe : structure.lobes)
        place(lobe);
    return placed;
}

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

// The part of the program that depends on the structure: macros and the two functions that run its
// models (see kernels/evaluate.cl and kernels/fit.cl).
std::string generated_text(const Structure& structure) {
    const StructureLayout layout = layout_of(structure);
    const std::vector<PlacedModel> placed = placed_models(structure);
    std::string bases;
    for (const DerivativeEntry& entry : layout.entries)
        bases += fmt::format("{}, ", entry.basis);
    std::string text = fmt::format(
        "#line 1 \"generated\"\n"
        "#define BASIS {}\n#define ENTRIES {}\n#define PLANES {}\n"
        "#define PARAMETERS {}\n#define ENTRY_BASIS {{{}0}}\n",
        layout.basis, layout.entries.size(), layout.planes,
        // of a set; where there are tables, there is one set
        structure.has_tables() ? 0 : std::max<std::size_t>(1, layout.parameters.size()), bases);
    const bool lobes = !structure.lobes.empty();
    text += fmt::format("#define FRESNEL {}\n#define LAST_LOBE {}\n",
                        lobes && structure.lobes.back()->fresnel() ? 1 : 0,
                        lobes ? layout.lobe_begin[structure.lobes.size() - 1] : 0);
    text += "static inline void material_prepare(geometry q, real* plane)\n{\n";
    for (const PlacedModel& p : placed)
        text +=
            fmt::format("    {}_prepare(q, plane + {});\n", p.model->identifier(), p.first_plane);
    text += "}\nstatic inline void material_basis(const real* plane, PARAMETER_SPACE const float* "
            "theta, real* b, real* d)\n{\n";
    const int diffuse_entry = layout.lobe_begin.back();
    text += fmt::format("    b[0] = {}(plane + {}, theta, {}d + {});\n",
                        structure.diffuse->identifier(), first_plane(placed, structure.diffuse),
                        table_argument(structure, *structure.diffuse, 0), diffuse_entry);
    for (std::size_t l = 0; l < structure.lobes.size(); ++l)
        text +=
            fmt::format("    b[{}] = {}(plane + {}, theta + {}, {}d + {});\n", l + 1,
                        structure.lobes[l]->identifier(), first_plane(placed, structure.lobes[l]),
                        layout.lobe_begin[l], table_argument(structure, *structure.lobes[l], l),
                        layout.lobe_begin[l]);
    return text + "}\n";
}

// The functions that draw from a structure's components (see kernels/sample.cl).
std::string generated_sampling(const Structure& structure) {
    const StructureLayout layout = layout_of(structure);
    std::string draw = "    if (j == 0)\n        return cosine_sample(wo, u1, u2);\n";
    std::string densities = "    p[0] = cosine_density(q);\n";
    for (std::size_t l = 0; l < structure.lobes.size(); ++l) {
        const std::string name = structure.lobes[l]->identifier();
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

std::string with_line(const std::string& path) {
    return fmt::format("#line 1 \"kernels/{}\"\n{}\n", path, kernel_source(path));
}

// The structure's models and the functions that run them.
std::string model_text(const Structure& structure) {
    std::string text = fmt::format("#define ROUGHNESSES {}\n", structure.isotropic ? 1 : 2);
    if (structure.has_tables())
        text = "#define TABLES\n" + text;
    for (const char* shared : {"common.cl", "geometry.cl", "schlick.cl", "beckmann.cl",
                               "sampling.cl", "cosine_power.cl", "trowbridge_reitz.cl"})
        text += with_line(shared);
    if (structure.has_tables())
        text += with_line("distribution.cl") + with_line("grid.cl");
    for (const PlacedModel& p : placed_models(structure))
        text += with_line(fmt::format("models/{}.cl", p.model->name));
    return text + generated_text(structure);
}

// The text, after the macros of the device's form, as a program.
cl::Program built(const Device& device, const std::string& text, const std::string& what) {
    const Form& form = device.form;
    cl::Program program(device.context,
                        fmt::format("#define V {}\n#define LS {}\n#define BLOCK {}\n"
                                    "#define CANDIDATES {}\n#define RUN {}\n",
                                    form.vector_width, form.local_size,
                                    form.block / form.vector_width, form.candidates, form.run()) +
                            text);
    try {
        program.build(device.handle, "-cl-std=CL1.2 -cl-mad-enable");
    } catch (const cl::Error&) {
        throw InputError(fmt::format("the kernels for {} do not build on {}:\n{}", what,
                                     device.name,
                                     program.getBuildInfo<CL_PROGRAM_BUILD_LOG>(device.handle)));
    }
    return program;
}

} // namespace

std::string Structure::name() const {
    if (lobes.empty())
        return diffuse->name;
    const bool coupled = diffuse->kind == Kind::DiffuseAndLobe;
    const bool one_model =
        std::all_of(lobes.begin(), lobes.end(), [&](const Model* m) { return m == lobes.front(); });
    std::string text = coupled ? diffuse->name : lobes.front()->name;
    for (std::size_t l = 1; l < lobes.size() && !one_model; ++l)
        text += "+" + lobes[l]->name;
    return text;
}

bool Structure::has_tables() const {
    return std::any_of(lobes.begin(), lobes.end(), [](const Model* m) { return m->table; });
}

std::string Structure::key() const {
    std::string text = diffuse->name + (isotropic ? " isotropic" : " anisotropic");
    for (const Model* lobe : lobes)
        text += " " + lobe->name;
    return text;
}

StructureLayout layout_of(const Structure& structure) {
    StructureLayout layout;
    layout.basis = 1 + static_cast<int>(structure.lobes.size());
    for (std::size_t l = 0; l < structure.lobes.size(); ++l) {
        layout.lobe_begin.push_back(static_cast<int>(layout.parameters.size()));
        for (const Parameter& parameter : structure.lobes[l]->parameters(structure.isotropic)) {
            layout.entries.push_back(
                {static_cast<int>(l) + 1, static_cast<int>(layout.parameters.size())});
            layout.parameters.push_back(parameter);
        }
    }
    layout.lobe_begin.push_back(static_cast<int>(layout.parameters.size()));
    // A coupled diffuse shape depends on the first lobe's f0.
    if (structure.diffuse->kind == Kind::DiffuseAndLobe)
        layout.entries.push_back({0, 0});
    for (const PlacedModel& p : placed_models(structure))
        layout.planes += p.model->planes(structure.isotropic);
    return layout;
}

std::string kernel_source(const std::string& path) {
    if (const char* folder = std::getenv("BRDFIT_KERNELS"))
        return std::string(MappedFile(fmt::format("{}/{}", folder, path)).bytes());
    for (const EmbeddedFile* file = embedded_kernels; file->name != nullptr; ++file)
        if (path == file->name)
            return file->text;
    throw InputError(fmt::format("kernels/{}: not among the kernels built in", path));
}

cl::Program build_program(const Device& device, const Structure& structure, int channels,
                          int chunk) {
    const std::string text =
        fmt::format("#define CHANNELS {}\n#define CHUNK {}\n", channels, chunk) +
        model_text(structure) + with_line("evaluate.cl") +
        (structure.has_tables() ? "" : with_line("fit.cl")); // what has tables is not fitted
    return built(device, text, structure.name());
}

cl::Program build_sample_program(const Device& device, const Structure& structure) {
    const std::string text = model_text(structure) + with_line("random.cl") +
                             generated_sampling(structure) + with_line("sample.cl");
    return built(device, text, structure.name());
}

cl::Program build_generator_program(const Device& device) {
    std::string text = "#define TABLES\n#define ROUGHNESSES 2\n";
    for (const char* path : {"common.cl", "geometry.cl", "schlick.cl", "sampling.cl",
                             "distribution.cl", "grid.cl", "generator.cl"})
        text += with_line(path);
    return built(device, text, "the generator");
}

cl::Program build_albedo_program(const Device& device, const Structure& structure) {
    const std::string text = model_text(structure) + with_line("random.cl") +
                             generated_sampling(structure) + with_line("albedo.cl");
    return built(device, text, structure.name());
}

cl::Program build_gram_program(const Device& device) {
    return built(device, with_line("common.cl") + with_line("gram.cl"), "the search");
}

cl::Program build_peaks_program(const Device& device) {
    return built(device, with_line("common.cl") + with_line("peaks.cl"), "the peaks");
}

std::string kernel_hash() {
    std::string text;
    for (const EmbeddedFile* file = embedded_kernels; file->name != nullptr; ++file)
        text += std::string(file->name) + '\n' + kernel_source(file->name) + '\n';
    return sha256(text);
}

} // namespace brdfit
