// Google Benchmark micro-benchmarks of what the host does: readers, packing, the linear solve, the
// global search. `build/brdfit_micro --benchmark_filter=read`.
#include "bench/problem.hpp"
#include "fit/fit.hpp"
#include "fit/nonnegative.hpp"
#include "fit/programs.hpp"
#include "fit/search.hpp"
#include "fit/structures.hpp"
#include "host/evaluate/synthesise.hpp"
#include "host/measured/read.hpp"
#include "host/measured/write.hpp"

#include <benchmark/benchmark.h>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>

namespace {

using namespace brdfit;

const Device& device() {
    static const Device opened = open_device();
    return opened;
}

const Samples& data() {
    static const Samples samples = bench::data_of(device(), 0);
    return samples;
}

// A file of measured data, written once and removed at the end.
class File {
  public:
    File(const Samples& samples, const std::string& ending)
        : path_((std::filesystem::temp_directory_path() /
                 fmt::format("brdfit-micro-{}{}", std::rand(), ending))
                    .string()) {
        write_samples(samples, path_);
    }
    ~File() {
        std::error_code ignored;
        std::filesystem::remove(path_, ignored);
    }
    File(const File&) = delete;
    File& operator=(const File&) = delete;
    const std::string& path() const { return path_; }

  private:
    std::string path_;
};

void read_file(benchmark::State& state, const Samples& samples, const char* ending) {
    const File file(samples, ending);
    for (auto _ : state)
        benchmark::DoNotOptimize(read_samples(file.path()).values.data());
    state.SetBytesProcessed(static_cast<std::int64_t>(state.iterations()) *
                            static_cast<std::int64_t>(std::filesystem::file_size(file.path())));
}

Samples scattered() {
    const bench::Problem problem = bench::problems({"kurt"}).front();
    return synthesise(device(), problem.material(), random_directions(100000, true, 1), 0.02, 1);
}

void read_merl(benchmark::State& state) {
    read_file(state, data(), ".binary");
}
void read_csv(benchmark::State& state) {
    read_file(state, scattered(), ".csv");
}
BENCHMARK(read_merl)->Unit(benchmark::kMillisecond);
BENCHMARK(read_csv)->Unit(benchmark::kMillisecond);

void pack(benchmark::State& state) {
    for (auto _ : state)
        benchmark::DoNotOptimize(pack_samples(device(), data(), 80, Metric::Ngan).count);
}
BENCHMARK(pack)->Unit(benchmark::kMillisecond);

// kd and the strengths of lobes, from their Gram matrix.
void solve(benchmark::State& state) {
    const auto unknowns = static_cast<int>(state.range(0));
    const SmallMatrix b = SmallMatrix::Random(unknowns, unknowns);
    const SmallMatrix gram = b.transpose() * b;
    const SmallVector projected = SmallVector::Random(unknowns),
                      reference = SmallVector::Zero(unknowns);
    for (auto _ : state)
        benchmark::DoNotOptimize(solve_nonnegative(gram, projected, 1, reference).squared_error);
}
BENCHMARK(solve)->DenseRange(1, max_unknowns);

// All shapes of one or two kurt lobes on a thinned copy, as a fit's global search does it.
void search(benchmark::State& state) {
    const auto lobes = static_cast<int>(state.range(0));
    const Structure structure = structure_named("kurt", lobes, "", true);
    const Structure single = structure_named("kurt", 1, "", true);
    ProgramCache programs(device());
    const DeviceSamples packed = pack_samples(device(), data(), 80, Metric::Ngan);
    const DeviceSamples thinned = thin_samples(device(), data(), packed, Metric::Ngan, 16384);
    Objective objective(device(), programs.get(single, packed.channels, packed.chunk), thinned);
    const std::vector<Objective*> objectives(static_cast<std::size_t>(lobes), &objective);
    const Space space(structure.lobes, true, {});
    const GramProgram gram = [&]() -> const SharedProgram& { return programs.gram(); };
    for (auto _ : state)
        benchmark::DoNotOptimize(
            search_shapes(device(), gram, objectives, space, {}, 6).front().squared_error);
}
BENCHMARK(search)->Arg(1)->Arg(2)->Unit(benchmark::kMillisecond)->UseRealTime();

} // namespace

BENCHMARK_MAIN();
