#include "tests/fuzz/fuzz.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fmt/format.h>
#include <mutex>
#include <png.h>
#include <set>
#include <sys/mman.h>
#include <unistd.h>

// Files that the readers map come as heap memory of their exact size, between what no one may read:
// the linker puts these in place of mmap and munmap (-Wl,--wrap).

extern "C" {

void* __real_mmap(void* at, std::size_t size, int protection, int flags, int file, off_t offset);
int __real_munmap(void* at, std::size_t size);

static std::mutex copies_mutex;
static std::set<void*>& copies() {
    static auto* const all = new std::set<void*>; // outlives every mapping
    return *all;
}

void* __wrap_mmap(void* at, std::size_t size, int protection, int flags, int file, off_t offset) {
    constexpr std::size_t largest = std::size_t{1} << 28; // the rest: /proc/kcore and the like
    if (file < 0 || protection != PROT_READ || size > largest)
        return __real_mmap(at, size, protection, flags, file, offset);
    void* const copy = std::malloc(size);
    std::size_t have = 0;
    while (have < size) {
        const ssize_t got = pread(file, static_cast<char*>(copy) + have, size - have,
                                  offset + static_cast<off_t>(have));
        if (got <= 0)
            break;
        have += static_cast<std::size_t>(got);
    }
    brdfit::fuzz::require(have == size, "a file that was not read whole");
    const std::lock_guard<std::mutex> lock(copies_mutex);
    copies().insert(copy);
    return copy;
}

int __wrap_munmap(void* at, std::size_t size) {
    {
        const std::lock_guard<std::mutex> lock(copies_mutex);
        if (copies().erase(at) == 0)
            return __real_munmap(at, size);
    }
    std::free(at);
    return 0;
}

} // extern "C"

namespace brdfit::fuzz {

const std::string& input_file(const std::uint8_t* data, std::size_t size) {
    static const int file = memfd_create("input", MFD_CLOEXEC);
    static const std::string path = fmt::format("/proc/self/fd/{}", file);
    require(file >= 0 && ftruncate(file, static_cast<off_t>(size)) == 0 &&
                pwrite(file, data, size, 0) == static_cast<ssize_t>(size),
            "an input that cannot be written");
    return path;
}

bool one_in(std::uint32_t count, const std::uint8_t* data, std::size_t size) {
    std::uint32_t hash = 2166136261U; // FNV-1a
    for (std::size_t i = 0; i < size; ++i)
        hash = (hash ^ data[i]) * 16777619U;
    static std::set<std::uint32_t> given; // many mutations change nothing
    return (hash ^ hash >> 16) % count == 0 && given.insert(hash).second;
}

const std::string& folder() {
    static const std::string path = [] {
        std::string name = (std::filesystem::temp_directory_path() / "brdfit-fuzz-XXXXXX").string();
        require(mkdtemp(name.data()) != nullptr, "no folder", name);
        return name;
    }();
    return path;
}

void require(bool holds, const char* what, const std::string& which) {
    if (holds)
        return;
    std::fprintf(stderr, "not as it should be: %s %s\n", what, which.c_str());
    std::abort();
}

void check(const Directions& directions) {
    require(directions.count() > 0, "no directions");
    require(std::all_of(directions.data().begin(), directions.data().end(),
                        [](float x) { return std::isfinite(x); }),
            "a direction that is not finite");
}

void check(const Samples& samples) {
    const std::size_t count = samples.count();
    require(count > 0 && !samples.channels.empty(), "samples without any");
    require(samples.values.size() == samples.channels.size() * count, "values of another number");
    require(samples.valid.size() == count, "marks of another number");
    require(samples.weights.empty() || samples.weights.size() == count,
            "weights of another number");
    check(*samples.directions);
    for (std::size_t k = 0; k < count; ++k) {
        if (samples.valid[k] == 0)
            continue;
        for (std::size_t c = 0; c < samples.channels.size(); ++c)
            require(std::isfinite(samples.channel(c)[k]), "a value that is not finite");
        require(samples.weights.empty() ||
                    (std::isfinite(samples.weights[k]) && samples.weights[k] >= 0),
                "a weight that is not finite");
    }
}

void check(const Image& image) {
    require(image.width > 0 && image.height > 0 && !image.channels.empty(), "an empty image");
    require(image.planes.size() == image.channels.size(), "planes of another number");
    for (const std::vector<float>& plane : image.planes)
        require(plane.size() == image.width * image.height, "a plane of another size");
}

void check(const MicrofacetTable& table) {
    require(table.g.size() == table.grid.count() && table.r0.size() == table.g.size(),
            "planes of another size");
    require(table.cells.size() == table.distribution.parts.size(), "cells of another number");
    for (const bool metal : {false, true}) {
        const TableUse use{0.5, metal, metal};
        require(packed_for_lobe(table, use).size() > table.g.size(), "a table without its planes");
        require(std::isfinite(diffuse_constant(table, use)), "a constant that is not finite");
    }
}

MicrofacetTable example_table(bool isotropic) {
    MicrofacetTable table;
    table.grid.rows = 4;
    table.grid.columns = isotropic ? 1 : 4;
    table.grid.sector = isotropic ? Sector::Isotropic : Sector::All;
    table.mean = {0, 0, 0.5};
    table.mean_height = 0.5;
    table.distribution.name = "example";
    table.distribution.sector = table.grid.sector;
    table.distribution.parts.resize(isotropic ? 1 : 3);
    for (auto* plane : {&table.g, &table.r0, &table.r1, &table.r0_correlated, &table.r1_correlated})
        plane->assign(table.grid.count(), 0.25F);
    table.cells.assign(table.distribution.parts.size(), {{0, 0.5, 1}, 1, {0.25F, 0.75F}});
    if (isotropic)
        return table;
    DistributionPart& velvet = table.distribution.parts[1];
    velvet.shape = Shape::Velvet;
    velvet.table =
        std::make_shared<DirectionTable>(DirectionTable{{}, {}, 2, 2, {0.5F, 1, 0.25F, 2}, 0.5});
    DistributionPart& tabulated = table.distribution.parts[2];
    tabulated.shape = Shape::Tabulated;
    tabulated.table = std::make_shared<DirectionTable>(
        DirectionTable{{0, 1.5}, {0, 3}, 2, 2, {1, 1, 0.5F, 0.25F}});
    table.facets = {4, 4, std::vector<float>(4 * 4 * 4, 0.125F)};
    return table;
}

Image example_image(const std::string& channel) {
    Image image{6, 5, {channel}, {std::vector<float>(30)}, {{"quantity", "example"}}};
    for (std::size_t i = 0; i < 30; ++i)
        image.planes[0][i] = 0.01F + static_cast<float>(i * i % 7) / 8;
    return image;
}

void write_png(const Image& image, const std::string& path) {
    std::vector<std::uint8_t> bytes;
    for (const float value : image.planes[0])
        bytes.push_back(static_cast<std::uint8_t>(255 * value));
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = static_cast<png_uint_32>(image.width);
    png.height = static_cast<png_uint_32>(image.height);
    png.format = PNG_FORMAT_GRAY;
    require(png_image_write_to_file(&png, path.c_str(), 0, bytes.data(), 0, nullptr) != 0, "no PNG",
            path);
}

} // namespace brdfit::fuzz
