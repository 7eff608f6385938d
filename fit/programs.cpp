#include "fit/programs.hpp"

#include "host/device/kernels.hpp"
#include "host/model/program.hpp"

#include <fmt/format.h>

namespace brdfit {

std::shared_ptr<const FitProgram> ProgramCache::get(const Structure& structure, int channels,
                                                    int chunk) {
    const std::string key = fmt::format("{} {} {}", structure.key(), channels, chunk);
    const std::lock_guard<std::mutex> lock(mutex_);
    for (const Entry& entry : entries_)
        if (entry.key == key)
            return entry.program;
    auto program = std::make_shared<FitProgram>(FitProgram{
        structure, layout_of(structure), build_program(device_, structure, channels, chunk)});
    entries_.push_back({key, program});
    return program;
}

const cl::Program& ProgramCache::gram() {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (!gram_)
        gram_ = build_gram_program(device_);
    return *gram_;
}

} // namespace brdfit
