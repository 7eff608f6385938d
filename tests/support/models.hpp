#pragma once

#include "host/model/material.hpp"

#include <gtest/gtest.h>
#include <string>
#include <vector>

// Which models of the catalogue a test runs over, and materials of them.

namespace brdfit::test {

/// Names of the models of the catalogue for which `wanted` holds.
template <typename Wanted>
std::vector<std::string> model_names(Wanted wanted) {
    std::vector<std::string> names;
    for (const Model& model : catalogue())
        if (wanted(model))
            names.push_back(model.name);
    return names;
}
/// All of them; lobes and coupled models, which can be fitted by themselves; lobes alone.
std::vector<std::string> all_model_names();
std::vector<std::string> fitted_model_names();
std::vector<std::string> lobe_model_names();

/// A model's name, or a mixture's, as a part of a test's.
std::string identifier_of(std::string models);
std::string test_name(const testing::TestParamInfo<std::string>& info);

/// Lobes over a Lambertian diffuse term, in one channel.
Material material_of(const std::vector<Lobe>& lobes, double kd = 0);

} // namespace brdfit::test
