#include "bench/formats.hpp"

#include "bench/problem.hpp"
#include "bench/scratch.hpp"
#include "host/evaluate/evaluate.hpp"
#include "host/evaluate/rgl.hpp"
#include "host/evaluate/synthesise.hpp"
#include "host/evaluate/tabulate.hpp"
#include "host/measured/formats.hpp"
#include "host/measured/read.hpp"
#include "host/measured/rgl.hpp"
#include "host/measured/write.hpp"

#include <filesystem>
#include <thread>

namespace brdfit::bench {

namespace {

constexpr std::size_t text_samples = 20000, evaluated_pairs = std::size_t{1} << 20;
constexpr std::size_t side = 64; // of the densities; measured files have 32 to 128

/// Tables with the densities that measured files have: theirs take the time.
RglTables tables_of(const Device& device) {
    const Material material = problems({"kurt"}).front().material();
    const BrdfFunction brdf = [&](const Directions& directions) {
        return evaluate(device, material, directions);
    };
    RglTables tables = tabulate(device, brdf, rgl_channels(material.channels, false, "bench"), true,
                                RglSize{1, 8, 32})
                           .tables;
    const auto density = [](std::size_t slices) {
        RglTables::Grid grid{side, side, std::vector<float>(slices * side * side)};
        for (std::size_t k = 0; k < grid.values.size(); ++k)
            grid.values[k] = 1 + static_cast<float>(k % side) / side;
        return grid;
    };
    tables.vndf = density(tables.slices());
    tables.ndf = density(1);
    return tables;
}

Result reading(const std::string& path) {
    Task task;
    task.work = read_work;
    const Samples samples = read_samples(path);
    task.model = samples.format.substr(0, samples.format.find(','));
    task.samples = static_cast<double>(samples.count());
    task.bytes_per_sample = static_cast<double>(std::filesystem::file_size(path)) / task.samples;
    task.run = [&] { read_samples(path); };
    return measure(task, "host", static_cast<int>(std::thread::hardware_concurrency()));
}

} // namespace

std::vector<Result> measure_reading(const Device& device, const Samples& data) {
    const Scratch folder;
    const Samples scattered = synthesise(device, problems({"kurt"}).front().material(),
                                         random_directions(text_samples, true, 1), 0, 1);
    write_samples(data, folder / "a.binary");
    for (const char* name : {"a.csv", "a.astm", "a.npy", "a.npz"})
        write_samples(scattered, folder / name);
    const zemax::Grid grid = zemax::written_grid(true);
    zemax::write(grid, 1, std::vector<float>(grid.blocks() * grid.block(), 0.5F),
                 folder / "zemax.bsdf", {});
    rgl::write(tables_of(device), folder / "rgl.bsdf");
    std::vector<Result> results;
    for (const char* name :
         {"a.binary", "rgl.bsdf", "zemax.bsdf", "a.astm", "a.csv", "a.npy", "a.npz"})
        results.push_back(reading(folder / name));
    return results;
}

Result measure_rgl(const Device& device, int threads) {
    const RglTables tables = tables_of(device);
    const auto pairs = random_directions(evaluated_pairs, true, 1);
    Task task;
    task.work = rgl_work;
    task.model = "RGL tensor file";
    task.samples = static_cast<double>(pairs->count());
    task.run = [&] { evaluate(device, tables, *pairs); };
    return measure(task, device.name, threads);
}

} // namespace brdfit::bench
