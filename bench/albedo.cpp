#include "bench/albedo.hpp"

#include "host/table/table.hpp"

#include <algorithm>
#include <chrono>
#include <fmt/format.h>

namespace brdfit::bench {

namespace {

constexpr std::size_t runs = 3;

} // namespace

nlohmann::ordered_json to_json(const AlbedoResult& result) {
    return {{"name", result.name},
            {"model", result.model},
            {"seconds", result.seconds},
            {"entries_per_second", result.entries_per_second}};
}

std::vector<AlbedoResult> measure_albedo_tables(const Device& device, std::size_t size) {
    std::vector<AlbedoResult> results;
    for (const Model& model : catalogue()) {
        if (model.kind != Kind::Lobe || !model.listed())
            continue;
        TableSpec spec = *find_preset("materialx");
        set_model(spec, model);
        TableSpec warm_up = spec;
        set_size(warm_up, 2);
        compute_table(device, warm_up);
        set_size(spec, size);
        std::vector<double> seconds;
        for (std::size_t run = 0; run < runs; ++run) {
            const auto start = std::chrono::steady_clock::now();
            compute_table(device, spec);
            seconds.push_back(
                std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
        }
        std::sort(seconds.begin(), seconds.end());
        const double median = seconds[runs / 2];
        results.push_back({fmt::format("albedo table {0} x {0}", size), model.name, median,
                           static_cast<double>(spec.entries()) / median});
    }
    return results;
}

} // namespace brdfit::bench
