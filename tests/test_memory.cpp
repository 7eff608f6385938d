// What reading a measured file takes: with the file itself, which is mapped, never more than four
// times its size. All that is allocated in this program is counted.

#include "host/measured/formats.hpp"
#include "host/measured/merl.hpp"
#include "host/measured/read.hpp"
#include "host/measured/rgl.hpp"
#include "host/measured/write.hpp"
#include "tests/support/examples.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>
#include <malloc.h>
#include <new>

namespace {

std::atomic<std::size_t> allocated{0}, most{0}; // bytes

} // namespace

#ifndef __SANITIZE_ADDRESS__ // which has its own

// Not inlined: the compiler sees no pair of malloc and delete, and warns of none.
[[gnu::noinline]] void* operator new(std::size_t size) {
    void* const made = std::malloc(size);
    if (made == nullptr)
        throw std::bad_alloc();
    const std::size_t now = allocated += malloc_usable_size(made);
    std::size_t before = most;
    while (before < now && !most.compare_exchange_weak(before, now)) {
    }
    return made;
}

[[gnu::noinline]] void operator delete(void* made) noexcept {
    if (made != nullptr)
        allocated -= malloc_usable_size(made);
    std::free(made);
}

[[gnu::noinline]] void operator delete(void* made, std::size_t) noexcept {
    operator delete(made);
}

#endif

namespace brdfit {

namespace {

/// Names, messages and the like, whatever the file's size.
constexpr std::size_t small_things = 16 << 10;

class Memory : public testing::Test {
  protected:
    void SetUp() override {
#ifdef __SANITIZE_ADDRESS__
        GTEST_SKIP() << "AddressSanitizer counts what is allocated itself";
#endif
    }
    void expect_little(const std::string& file) {
        const std::size_t size = std::filesystem::file_size(file), before = allocated;
        most = before;
        const Samples samples = read_samples(file);
        const std::size_t taken = most - before;
        EXPECT_GE(taken, samples.count() * (Directions::plane_count + samples.channels.size()) *
                             sizeof(float))
            << "more than that was made";
        EXPECT_LE(taken + size, 4 * size + small_things)
            << file << ": " << static_cast<double>(taken + size) / static_cast<double>(size)
            << " times its size, " << samples.count() << " samples";
    }
    const test::TemporaryFolder folder;
};

TEST_F(Memory, of_real_files_is_four_times_their_size) {
    if (test::data_folder().empty())
        GTEST_SKIP() << "BRDFIT_DATA is not set";
    for (const char* room : {"rgl", "cornell", "ua-loft", "alta"})
        for (const auto& entry : std::filesystem::directory_iterator(test::data_folder() / room)) {
            const std::string ending = entry.path().extension().string();
            if (!ending.empty() && ending != ".exr")
                expect_little(entry.path().string());
        }
}

TEST_F(Memory, of_files_that_convert_writes_is_four_times_their_size) {
    // Numbers with as many digits as they have.
    const zemax::Grid grid = zemax::written_grid(false);
    const auto directions = std::make_shared<const Directions>(zemax::directions_of(grid));
    Samples samples;
    samples.channels = {"R", "G", "B"};
    samples.isotropic = false;
    samples.directions = directions;
    samples.weights.assign(directions->count(), 0.1F);
    for (std::size_t i = 0; i < 3 * directions->count(); ++i)
        samples.values.push_back(1 / (1 + static_cast<float>(i % 1009)));
    for (std::size_t k = 0; k < directions->count(); ++k)
        samples.valid.push_back(k % 8 == 0 && directions->above_horizon(k) ? 1 : 0);
    for (const char* name : {"s.csv", "s.astm", "s.npy", "s.npz"}) {
        write_samples(samples, folder / name);
        expect_little(folder / name);
    }
    for (const std::size_t channels : {1U, 3U}) {
        zemax::write(grid, channels, samples.values, folder / "zemax.bsdf", {});
        expect_little(folder / "zemax.bsdf");
    }
    RglTables tables;
    tables.channels = {"R", "G", "B"};
    tables.phi_i = {0};
    constexpr std::size_t side = 64, incidences = 32;
    for (std::size_t t = 0; t < incidences; ++t)
        tables.theta_i.push_back(1.55F * static_cast<float>(t) / (incidences - 1));
    tables.ndf = {2, 2, std::vector<float>(4, 1.0F)};
    tables.sigma = {2, 2, std::vector<float>(4, 0.25F)};
    tables.vndf = {2, 2, std::vector<float>(4 * incidences, 1.0F)};
    tables.table = {side, side, std::vector<float>(3 * incidences * side * side, 0.5F)};
    tables.luminance = {side, side, std::vector<float>(incidences * side * side, 0.5F)};
    rgl::write(tables, folder / "rgl.bsdf");
    expect_little(folder / "rgl.bsdf");
}

TEST_F(Memory, of_files_known_by_their_size_is_four_times_that) {
    test::write_file(folder / "file", "");
    std::filesystem::resize_file(folder / "file", utia::channels * utia::directions *
                                                      utia::directions * sizeof(double));
    expect_little(folder / "file");
    test::write_file(folder / "file", test::merl_header(90, 90, 180));
    std::filesystem::resize_file(folder / "file", 12 + 3 * merl::bins * sizeof(double));
    expect_little(folder / "file");
}

} // namespace

} // namespace brdfit
