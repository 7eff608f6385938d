#include "tests/support/cli.hpp"

#include <algorithm>
#include <chrono>
#include <stdexcept>
#include <thread>

namespace brdfit::test {

namespace {

const std::string isotropic_material = R"({
  "brdfit": 1, "channels": ["R", "G", "B"],
  "diffuse": {"model": "lambert", "kd": [0.1, 0.2, 0.3]},
  "lobes": [{"model": "kurt", "ks": [0.5, 0.4, 0.3], "f0": 0.5, "m": 0.2, "alpha": 0.1}]})";
const std::string anisotropic_material = R"({
  "brdfit": 1, "channels": ["R", "G", "B"],
  "diffuse": {"model": "lambert", "kd": [0.1, 0.2, 0.3]},
  "lobes": [{"model": "ward", "ks": [0.5, 0.4, 0.3], "mx": 0.2, "my": 0.4}]})";

} // namespace

Names names_in(const std::filesystem::path& folder) {
    Names names;
    if (std::filesystem::exists(folder))
        for (const auto& entry : std::filesystem::directory_iterator(folder))
            names.push_back(entry.path().filename().string());
    std::sort(names.begin(), names.end());
    return names;
}

Cli::Cli() {
    write_file(folder / "paint.json", isotropic_material);
    write_file(folder / "brushed.json", anisotropic_material);
    synthesise("paint", "paint.csv");
}

void Cli::synthesise(const std::string& material, const std::string& file, int count) {
    const Outcome outcome = run_program({"synth", folder / (material + ".json"), folder / file,
                                         "--directions", std::to_string(count), "--noise", "0.02"});
    if (outcome.status != 0)
        throw std::runtime_error(outcome.err);
}

Outcome Cli::fit(const std::vector<std::string>& options) const {
    std::vector<std::string> arguments{"fit", folder / "paint.csv", "-o", folder / "out",
                                       "--force"};
    arguments.insert(arguments.end(), options.begin(), options.end());
    return run_program(arguments);
}

nlohmann::json Cli::fit_json(std::vector<std::string> options) const {
    options.emplace_back("--json");
    const Outcome outcome = fit(options);
    EXPECT_EQ(outcome.status, 0) << outcome.err;
    return nlohmann::json::parse(outcome.out);
}

Material Cli::written(const std::string& name) const {
    return read_material((folder.path() / "out" / name).string());
}

Names Cli::out_names() const {
    return names_in(folder.path() / "out");
}

Outcome interrupted(const std::vector<std::string>& arguments, const std::filesystem::path& folder,
                    const std::function<bool(const std::string& name)>& seen, int signal) {
    return run_program(arguments, {}, [&](pid_t child) {
        const auto any = [&] {
            const Names names = names_in(folder);
            return std::any_of(names.begin(), names.end(), seen);
        };
        for (int i = 0; i < 30000 && !any(); ++i)
            std::this_thread::sleep_for(std::chrono::milliseconds(1));
        kill(child, signal);
        // LLVM, with which PoCL compiles, passes over the first fault that is no instruction's.
        std::this_thread::sleep_for(std::chrono::milliseconds(20));
        kill(child, signal);
    });
}

namespace {

void expect_error(const Outcome& outcome, int status, const std::string& says) {
    EXPECT_EQ(outcome.status, status) << outcome.err;
    EXPECT_NE(outcome.err.find("brdfit: error: "), std::string::npos) << outcome.err;
    EXPECT_NE(outcome.err.find(says), std::string::npos) << outcome.err;
}

} // namespace

void expect_usage_error(const Outcome& outcome, const std::string& says) {
    expect_error(outcome, 2, says);
}

void expect_input_error(const Outcome& outcome, const std::string& says) {
    expect_error(outcome, 1, says);
}

} // namespace brdfit::test
