#pragma once

#include "bench/problem.hpp"
#include "bench/work.hpp"
#include "host/device/device.hpp"

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

// Whether devices agree: what each kernel of each model computes on the same inputs, held against
// float64, and how fast. A device is measured by a process of its own, as a driver may crash.

namespace brdfit::bench {

/// The largest relative difference of a kernel's results from float64's: of single values
/// ("values", those below a millionth of the largest as a share of that), or as difference() in
/// work.hpp takes it ("albedo": from the first device's).
struct Agreement {
    std::string model, kernel;
    double difference, tolerance;
    bool wrong() const { return !(difference < tolerance); }
};

/// What was found on one device.
struct Portability {
    std::string device, platform, driver, form, failure; ///< failure: empty where there is none
    int threads = 0;
    std::vector<Agreement> agreements;
    std::vector<std::pair<std::string, double>> albedos; ///< of each lobe model
    Measured measured; ///< eval, error-gradient and search of kurt and ggx on a whole file
    double cold = 0, cached = 0; ///< seconds to build the kernels of a kurt fit
};

/// Measures a device in this process; `most` as for data_of, for the speeds.
Portability measure_portability(const Device& device, const std::vector<Problem>& problems,
                                std::size_t most);

nlohmann::ordered_json to_json(const Portability& portability);
/// Back from the message of the process that measured. Throws nlohmann's exceptions.
nlohmann::ordered_json portability_message(const Portability& portability);
Portability portability_from_message(const nlohmann::ordered_json& json);

/// Adds each device's agreement of albedos with the first that has them.
void compare_albedos(std::vector<Portability>& devices);

/// The table of all devices, in Markdown.
std::string portability_table(const std::vector<Portability>& devices);

} // namespace brdfit::bench
