#include "bench/opencl.hpp"

#include "fit/objective.hpp"

namespace brdfit::bench {

std::vector<Result> measure_device(const Device& device, const Problem& problem,
                                   const Samples& samples) {
    constexpr double whole_hemisphere = 90;
    const Structure structure = structure_of(parse_material(problem.material, "problem"));
    const DeviceSamples packed = pack_samples(device, samples, whole_hemisphere, Metric::Ngan);
    ProgramCache cache(device);
    Objective objective(device, cache.get(structure, packed.channels, packed.chunk), packed);
    std::vector<Result> results;
    for (const Work& work : works) {
        Result result;
        result.device = device.name;
        result.work = work.name;
        result.model = structure.name();
        result.threads = static_cast<int>(device.compute_units);
        result.bytes_per_sample =
            static_cast<double>(sizeof(float)) * (objective.layout().planes + packed.channels + 1);
        const Timing timing = time_runs([&] {
            result.answer.error = objective.projected_error(
                problem.theta, work.gradient ? &result.answer.gradient : nullptr);
        });
        result.samples_per_second = static_cast<double>(packed.count) / timing.median;
        result.spread = timing.spread;
        results.push_back(std::move(result));
    }
    return results;
}

bool can_run_on_one_thread(const Device& device) {
    return device.cpu && device.platform == "Portable Computing Language";
}

} // namespace brdfit::bench
