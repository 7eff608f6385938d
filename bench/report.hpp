#pragma once

#include "bench/work.hpp"
#include "host/device/device.hpp"

#include <string>
#include <vector>

namespace brdfit::bench {

/// What was promised of a processor, and what it came to.
struct Target {
    std::string name;
    double value, least;
    bool at_most; ///< `least` is the most instead
    /// What does instead of `least`, where there is such a thing.
    struct Instead {
        double value = 0, least = 0;
        std::string what;
    } instead;
    bool met() const {
        return (at_most ? value <= least : value >= least) ||
               (instead.least > 0 && instead.value >= instead.least);
    }
};

/// All that one run of `brdfit bench` found.
struct Report {
    std::vector<Device> devices;
    std::size_t samples = 0; ///< that the works but sample and fit handle
    Measured measured;
    std::vector<CompileTime> compile;
};

/// Sets the differences from the baseline's answers. Throws InputError for an answer that is
/// further off than its work allows: no number is worth anything then.
void check_answers(std::vector<Result>& results);

/// The row of that device, work, model and number of threads, or nullptr.
const Result* find_result(const std::vector<Result>& results, const std::string& device,
                          const std::string& work, const std::string& model, int threads);

std::vector<Target> targets_of(const Report& report);
/// Tables of all rows, then the targets, to standard output.
void print(const Report& report);
nlohmann::ordered_json to_json(const Report& report);

} // namespace brdfit::bench
