#pragma once

#include "host/microfacet/table.hpp"
#include "host/model/catalogue.hpp"

#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace brdfit {

/// One specular lobe: per-channel strength and the shape all channels share.
struct Lobe {
    const Model* model = nullptr;
    bool isotropic = true;     ///< whether theta has the isotropic form
    std::vector<double> theta; ///< in the order of model->parameters(isotropic)
    std::vector<double> ks;    ///< >= 0, one a channel
    /// Where the model reads a table: it, its name in the material file, and whether shadowing is
    /// correlated.
    std::shared_ptr<const MicrofacetTable> table = nullptr;
    std::string table_file = {};
    bool correlated = false;

    /// theta in the anisotropic form (one roughness repeated).
    std::vector<double> anisotropic_theta() const;
};

/// f_ch(wi, wo) = kd_ch diffuse(wi, wo) + sum over lobes of ks_ch g(wi, wo; theta).
struct Material {
    std::vector<std::string> channels;
    const Model* diffuse = nullptr; ///< of Kind::Diffuse or DiffuseAndLobe
    std::vector<double> kd;         ///< >= 0, one a channel
    bool metal = false;             ///< of a diffuse shape that reads a table, Eq. 30
    std::vector<Lobe> lobes;        ///< 0 to 4
    nlohmann::ordered_json fit;     ///< how it was fitted; null when it was not

    bool isotropic() const; ///< every lobe isotropic, or with equal roughnesses
};

inline constexpr std::size_t max_lobes = 4;

/// Parses a material file's text. `source` names it in messages.
/// Throws InputError naming source, key and expectation for anything not in the format of
/// README.md: unknown or missing keys, wrong types, NaN, values out of the catalogue's range. Table
/// files are read relative to `source`.
Material parse_material(const std::string& text, const std::string& source);
Material read_material(const std::string& path);
nlohmann::ordered_json to_json(const Material& material);
/// Writes the file whole or not at all.
void write_material(const Material& material, const std::string& path);

} // namespace brdfit
