#include "fit/programs.hpp"

#include "host/device/kernels.hpp"
#include "host/model/program.hpp"

#include <chrono>
#include <fmt/format.h>

namespace brdfit {

namespace {

double seconds_since(std::chrono::steady_clock::time_point started) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
}

} // namespace

void BuildSeconds::add(double seconds) {
    const std::lock_guard<std::mutex> lock(mutex_);
    seconds_[std::this_thread::get_id()] += seconds;
}

double BuildSeconds::of_this_thread() {
    const std::lock_guard<std::mutex> lock(mutex_);
    return seconds_[std::this_thread::get_id()];
}

std::shared_ptr<const FitProgram> ProgramCache::get(const Structure& structure, int channels,
                                                    int chunk) {
    const std::string key = fmt::format("{} {} {}", structure.key(), channels, chunk);
    const auto started = std::chrono::steady_clock::now();
    const std::shared_ptr<const FitProgram>& program = programs_.get(key, [&] {
        auto program = std::make_shared<FitProgram>();
        program->structure = structure;
        program->layout = layout_of(structure);
        program->program = build_program(device_, structure, channels, chunk);
        program->build_seconds = seconds_;
        return program;
    });
    seconds_->add(seconds_since(started)); // or of waiting for it
    return program;
}

const SharedProgram& ProgramCache::gram() {
    return *gram_.get("", [&] {
        const auto started = std::chrono::steady_clock::now();
        auto program = std::make_shared<SharedProgram>();
        program->program = build_gram_program(device_);
        seconds_->add(seconds_since(started));
        return program;
    });
}

AlbedoIntegrator& ProgramCache::integrator(const Model* diffuse, const Model* lobe,
                                           AlbedoTask like) {
    const std::pair key(diffuse, lobe);
    auto known = integrators_.find(key);
    if (known == integrators_.end()) {
        const auto started = std::chrono::steady_clock::now();
        Structure structure{diffuse != nullptr ? diffuse : &model_named("lambert"), {}, false};
        if (lobe != nullptr)
            structure.lobes.push_back(lobe);
        known = integrators_
                    .emplace(key, AlbedoIntegrator(device_, structure, diffuse != nullptr ? 0 : 1))
                    .first;
        // The first runs of its kernels may compile them.
        like.relative = 1;
        known->second.integrate({like});
        seconds_->add(seconds_since(started));
    }
    return known->second;
}

std::vector<AlbedoValue> ProgramCache::albedos(const Model* diffuse, const Model* lobe,
                                               const std::vector<AlbedoTask>& tasks) {
    const std::lock_guard<std::mutex> lock(albedo_mutex_);
    return tasks.empty() ? std::vector<AlbedoValue>{}
                         : integrator(diffuse, lobe, tasks.front()).integrate(tasks);
}

void ProgramCache::build_ahead(const Structure& structure, int channels, int chunk) noexcept {
    try {
        get(structure, channels, chunk);
        for (const Model* const lobe : structure.lobes) {
            AlbedoTask like;
            like.wo = direction(0.5, 0);
            for (const Parameter& parameter : lobe->parameters(false))
                like.theta.push_back(parameter.start);
            const std::lock_guard<std::mutex> lock(albedo_mutex_);
            integrator(nullptr, lobe, like);
        }
    } catch (const std::exception&) { // the fit says what
    }
}

} // namespace brdfit
