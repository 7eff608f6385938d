#include "tests/support/models.hpp"

#include <algorithm>
#include <cctype>

namespace brdfit::test {

std::vector<std::string> all_model_names() {
    return model_names([](const Model&) { return true; });
}

std::vector<std::string> fitted_model_names() {
    return model_names([](const Model& model) { return model.kind != Kind::Diffuse; });
}

std::vector<std::string> lobe_model_names() {
    return model_names([](const Model& model) { return model.kind == Kind::Lobe; });
}

std::string identifier_of(std::string models) {
    std::replace_if(
        models.begin(), models.end(), [](unsigned char c) { return std::isalnum(c) == 0; }, '_');
    return models;
}

std::string test_name(const testing::TestParamInfo<std::string>& info) {
    return identifier_of(info.param);
}

Material material_of(const std::vector<Lobe>& lobes, double kd) {
    Material material;
    material.channels = {"Y"};
    material.diffuse = &model_named("lambert");
    material.kd = {kd};
    material.lobes = lobes;
    return material;
}

} // namespace brdfit::test
