#include "host/table/table.hpp"

namespace brdfit {

namespace {

Axis cosine(std::size_t size, Nodes nodes, double least = 0) {
    Axis axis;
    axis.kind = AxisKind::CosTheta;
    axis.size = size;
    axis.nodes = nodes;
    axis.least = least;
    return axis;
}

Axis roughness(std::size_t size, Nodes nodes, double power, double least = 0) {
    Axis axis = cosine(size, nodes, least);
    axis.kind = AxisKind::Roughness;
    axis.power = power;
    return axis;
}

Axis openpbr_ior(std::size_t size) {
    Axis axis = cosine(size, Nodes::Corners);
    axis.kind = AxisKind::Ior;
    axis.reciprocal = true;
    return axis;
}

TableSpec table(const std::string& name, const std::string& description, Quantity quantity,
                std::vector<Axis> axes, std::vector<std::string> channels) {
    TableSpec spec;
    spec.name = name;
    spec.description = description;
    spec.model = &model_named("ggx");
    spec.quantity = quantity;
    spec.axes = std::move(axes);
    spec.channels = std::move(channels);
    return spec;
}

/// A cosine of 0 means the limit; renderers that divide by it begin a little above.
constexpr double least_cosine = 1e-4;

std::vector<Preset> make_presets() {
    std::vector<Preset> all;
    const auto add = [&](const std::string& name, const std::string& renderer, TableSpec spec) {
        all.push_back({name, renderer, std::move(spec)});
    };

    // x = NoV, y = coord from 1 down, alpha = coord^2.
    const std::vector<Axis> filament{cosine(128, Nodes::Centres),
                                     roughness(128, Nodes::Descending, 2)};
    TableSpec dfg = table("DFG_LUT", "DFG for multiple scattering: mix(x, y, f0)",
                          Quantity::MultipleScattering, filament, {"R", "G", "B"});
    dfg.encoding = Encoding::Half;
    dfg.style = SourceStyle::Cmgen;
    dfg.third_channel = true;
    add("filament", "Filament, cmgen --ibl-dfg --ibl-dfg-multiscatter", dfg);
    dfg.quantity = Quantity::ScaleBias;
    dfg.description = "DFG for single scattering: f0 x + f90 y";
    add("filament-single", "Filament, cmgen --ibl-dfg", dfg);

    TableSpec cycles = table(
        "table_ggx_E", "directional albedo E", Quantity::Albedo,
        {roughness(32, Nodes::Corners, 2, 1e-4), cosine(32, Nodes::Corners, least_cosine)}, {"E"});
    cycles.tolerance = 1e-5;
    add("cycles", "Cycles, ggx_E of shader.tables", cycles);
    cycles.name = "table_ggx_Eavg";
    cycles.description = "average albedo E";
    cycles.axes.pop_back();
    add("cycles-average", "Cycles, ggx_Eavg of shader.tables", cycles);

    TableSpec openpbr = table(
        "OpenPBR_IdealMetalEnergyComplement_Array", "1 - E of an ideal metal", Quantity::Complement,
        {cosine(32, Nodes::Corners, least_cosine), roughness(32, Nodes::Corners, 2)},
        {"complement"});
    openpbr.model = &model_named("ggx-uncorrelated"); // its G2 is G1(wi) G1(wo)
    openpbr.encoding = Encoding::Unorm16;
    openpbr.style = SourceStyle::Fragment;
    openpbr.tolerance = 1e-5;
    add("openpbr", "OpenPBR reference implementation, ideal metal", openpbr);
    TableSpec average = openpbr;
    average.name = "OpenPBR_IdealMetalAverageEnergyComplement_Array";
    average.description = "average 1 - E of an ideal metal";
    average.axes.erase(average.axes.begin());
    add("openpbr-average", "OpenPBR reference implementation, ideal metal, average", average);
    openpbr.axes.push_back(openpbr_ior(32));
    openpbr.name = "OpenPBR_OpaqueDielectricEnergyComplement_Array";
    openpbr.description = "1 - E of an opaque dielectric (reflection alone)";
    openpbr.tolerance = 5e-5;
    add("openpbr-dielectric", "OpenPBR reference implementation, opaque dielectric", openpbr);
    average.axes.push_back(openpbr_ior(32));
    average.name = "OpenPBR_OpaqueDielectricAverageEnergyComplement_Array";
    average.description = "average 1 - E of an opaque dielectric (reflection alone)";
    average.tolerance = 5e-5;
    add("openpbr-dielectric-average",
        "OpenPBR reference implementation, opaque dielectric, average", average);

    add("materialx", "MaterialX, directional albedo of conductors and dielectrics",
        table("mx_ggx_dir_albedo", "E = F0 R + F90 G", Quantity::ScaleBias,
              {cosine(64, Nodes::Centres), roughness(64, Nodes::Centres, 1)}, {"R", "G"}));
    TableSpec gltf =
        table("lut_ggx", "scale and bias of F0", Quantity::ScaleBias,
              {cosine(1024, Nodes::Centres), roughness(1024, Nodes::Centres, 2)}, {"R", "G", "B"});
    gltf.encoding = Encoding::Half;
    gltf.third_channel = true;
    add("gltf", "glTF sample viewer, lut_ggx", gltf);

    TableSpec osl =
        table("ggx_energy_complement", "1 - E", Quantity::Complement,
              {cosine(16, Nodes::Corners, 1e-3), roughness(16, Nodes::Corners, 1)}, {"complement"});
    osl.axes[0].power = 2;
    osl.tolerance = 1e-5;
    add("osl", "OSL BSDL, metal (Fresnel index 0)", osl);

    TableSpec kulla = table("kulla_conty_E", "directional albedo E", Quantity::Albedo,
                            {cosine(32, Nodes::Centres), roughness(32, Nodes::Centres, 1)}, {"E"});
    add("kulla-conty", "Kulla and Conty 2017, E", kulla);
    kulla.name = "kulla_conty_Eavg";
    kulla.description = "average albedo E";
    kulla.axes.erase(kulla.axes.begin());
    kulla.channels = {"E_avg"};
    add("kulla-conty-average", "Kulla and Conty 2017, E_avg", kulla);
    return all;
}

} // namespace

const std::vector<Preset>& presets() {
    static const std::vector<Preset> all = make_presets();
    return all;
}

const TableSpec* find_preset(const std::string& name) {
    for (const Preset& preset : presets())
        if (preset.name == name)
            return &preset.spec;
    return nullptr;
}

} // namespace brdfit
