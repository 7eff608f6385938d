// OpenEXR and PNG images: what is written is read, and broken files are errors that name them.
#include "host/error.hpp"
#include "host/image/image.hpp"
#include "host/image/plot.hpp"
#include "host/image/preview.hpp"
#include "tests/support/support.hpp"

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfTiledOutputFile.h>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <gtest/gtest.h>
#include <limits>
#include <png.h>
#include <random>

using namespace brdfit;
using test::TemporaryFolder;

namespace {

Image noise(std::size_t width, std::size_t height) {
    Image image{
        width, height, {"R", "albedo.G", "z"}, {}, {{"quantity", "albedo"}, {"axes", "x, y"}}};
    std::mt19937 random(1);
    std::uniform_real_distribution<float> uniform(-1, 1);
    for (std::size_t ch = 0; ch < image.channels.size(); ++ch)
        for (std::size_t i = 0; i < width * height; ++i) {
            if (i == 0)
                image.planes.emplace_back();
            image.planes[ch].push_back(uniform(random));
        }
    return image;
}

void write_png(const std::string& path, png_uint_32 width, png_uint_32 height, png_uint_32 format,
               const void* values) {
    png_image png{};
    png.version = PNG_IMAGE_VERSION;
    png.width = width;
    png.height = height;
    png.format = format;
    ASSERT_NE(png_image_write_to_file(&png, path.c_str(), 0, values, 0, nullptr), 0);
}

// Whether reading refuses the file, by an InputError that names it; what it reads is a whole image.
bool refused(const std::string& path, Image (*read)(const std::string&)) {
    Image image;
    const std::string message = test::complaint([&] { image = read(path); });
    if (!message.empty()) {
        EXPECT_NE(message.find(path), std::string::npos) << message;
        return true;
    }
    EXPECT_GT(image.width, 0U);
    EXPECT_GT(image.height, 0U);
    EXPECT_FALSE(image.channels.empty());
    EXPECT_EQ(image.planes.size(), image.channels.size());
    for (const std::vector<float>& plane : image.planes)
        EXPECT_EQ(plane.size(), image.width * image.height);
    return false;
}

// How many of `count` copies of a file with up to three bytes changed are refused; in every second
// copy they lie within the first `head` bytes.
int refused_of_damaged(const std::string& path, Image (*read)(const std::string&), std::size_t head,
                       int count) {
    const std::string whole = test::read_file(path);
    std::mt19937 random(2);
    int number = 0;
    for (int k = 0; k < count; ++k) {
        std::string damaged = whole;
        const std::size_t most = k % 2 == 0 ? head : whole.size();
        for (int bytes = 0; bytes < 1 + k % 3; ++bytes)
            damaged[random() % most] = static_cast<char>(random());
        test::write_file(path, damaged);
        number += refused(path, read);
    }
    return number;
}

} // namespace

TEST(Exr, floats_come_back_exactly) {
    const TemporaryFolder folder;
    Image image = noise(37, 21);
    image.planes[0][5] = std::numeric_limits<float>::infinity();
    image.planes[2][0] = 1e-40F;
    write_exr(image, folder / "a.exr", ExrPixel::Float);
    const Image back = read_exr(folder / "a.exr");
    EXPECT_EQ(back.width, image.width);
    EXPECT_EQ(back.height, image.height);
    EXPECT_EQ(back.metadata, image.metadata);
    ASSERT_EQ(back.channels, image.channels);
    EXPECT_EQ(back.planes, image.planes);
    EXPECT_EQ(back.plane("z"), &back.planes[2]);
    EXPECT_EQ(back.plane("G"), nullptr);
}

TEST(Exr, halves_are_rounded_to_11_bits) {
    const TemporaryFolder folder;
    const Image image = noise(8, 8);
    write_exr(image, folder / "a.exr", ExrPixel::Half);
    const Image back = read_exr(folder / "a.exr");
    for (std::size_t ch = 0; ch < 3; ++ch)
        for (std::size_t i = 0; i < 64; ++i)
            EXPECT_NEAR(back.planes[ch][i], image.planes[ch][i],
                        std::fabs(image.planes[ch][i]) / 2048 + 1e-7);
    EXPECT_NE(back.planes, image.planes);
}

TEST(Exr, wrong_images_are_not_written) {
    const TemporaryFolder folder;
    Image image = noise(4, 4);
    image.planes[1].pop_back();
    EXPECT_THROW(write_exr(image, folder / "a.exr", ExrPixel::Float), UsageError);
    image = noise(4, 4);
    image.channels[1] = "R";
    EXPECT_THROW(write_exr(image, folder / "a.exr", ExrPixel::Float), UsageError);
    EXPECT_THROW(write_exr(noise(4, 4), folder / "missing/a.exr", ExrPixel::Float), InputError);
    EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Exr, broken_files_are_errors) {
    const TemporaryFolder folder;
    const std::string path = folder / "a.exr";
    write_exr(noise(40, 40), path, ExrPixel::Float);
    const std::string whole = test::read_file(path);
    for (std::size_t k = 0; k < 60; ++k) {
        test::write_file(path, whole.substr(0, whole.size() * k / 60));
        EXPECT_TRUE(refused(path, read_exr)) << k;
    }
    // Any damage is either noticed or leaves a whole image.
    test::write_file(path, whole);
    const int noticed = refused_of_damaged(path, read_exr, 400, 400);
    EXPECT_GT(noticed, 100);
    EXPECT_LT(noticed, 400);
    EXPECT_TRUE(refused(folder / "none.exr", read_exr));
    EXPECT_TRUE(refused(folder.path().string(), read_exr));
}

TEST(Exr, a_header_cannot_make_it_allocate) {
    const TemporaryFolder folder;
    const std::string path = folder / "a.exr";
    write_exr(noise(4, 4), path, ExrPixel::Float);
    std::string bytes = test::read_file(path);
    const std::size_t window = bytes.find("box2i", bytes.find("dataWindow")) + 6 + 4;
    for (const int size : {100000, 1 << 30}) {
        for (std::size_t i = 0; i < 4; ++i) {
            bytes[window + 8 + i] = static_cast<char>(size >> (8 * i));
            bytes[window + 12 + i] = static_cast<char>(size >> (8 * i));
        }
        test::write_file(path, bytes);
        EXPECT_TRUE(refused(path, read_exr));
    }
}

// A header's sizes are judged before anything is allocated for them.
TEST(Exr, sizes_of_a_header_are_errors_with_their_place) {
    const TemporaryFolder folder;
    const std::string path = folder / "a.exr";
    const auto number = [](std::int64_t value) {
        std::string bytes;
        for (int i = 0; i < 4; ++i)
            bytes += static_cast<char>(value >> (8 * i));
        return bytes;
    };
    const std::string start = "\x76\x2f\x31\x01" + number(2);
    const auto attribute = [&](const std::string& name, const std::string& type,
                               const std::string& value) {
        return name + '\0' + type + '\0' + number(static_cast<std::int64_t>(value.size())) + value;
    };
    const auto window = [&](std::int64_t right, std::int64_t bottom) {
        return attribute("dataWindow", "box2i",
                         number(0) + number(0) + number(right) + number(bottom));
    };
    const std::string channels =
        attribute("channels", "chlist",
                  std::string("R\0", 2) + number(2) + number(0) + number(1) + number(1) + '\0');
    const std::string compression = attribute("compression", "compression", std::string(1, '\0'));
    const std::string zero(1, '\0'), tiled_start = "\x76\x2f\x31\x01" + number(0x202),
                                     parts_start = "\x76\x2f\x31\x01" + number(0x1002);
    const auto tiles = [&](std::int64_t width, std::int64_t height) {
        return attribute("tiles", "tiledesc", number(width) + number(height) + zero);
    };
    const std::string huge_attribute = std::string("a\0string\0", 9) + number(2147483647);
    const std::vector<std::pair<std::string, std::string>> files{
        {start + huge_attribute, "attribute 'a': byte 21: a size of 2147483647 bytes"},
        {start + std::string("a\0string\0", 9) + number(-1), "attribute 'a': a size of -1"},
        {start + std::string(300, 'n'), "byte 8: a name does not end within 256 bytes"},
        {start + std::string("a\0str", 5), "byte 10: a name"},
        {start + attribute("channels", "chlist", "R"), "attribute 'channels': byte 28"},
        {start + attribute("x", "chlist", "R"), "attribute 'x': byte 21"},
        {start + attribute("dataWindow", "box2i", std::string(17, '\0')),
         "attribute 'dataWindow': byte 29: a size of 17 bytes; expected 16"},
        {start + attribute("channels", "chlist", std::string(3, '\0')), "2 bytes after the last"},
        {start + channels + compression + zero, "has no attribute dataWindow"},
        {start + window(0, 1) + compression + zero, "has no attribute channels"},
        {start + channels + compression + window(-5, 0) + zero, "attribute 'dataWindow'"},
        {start + channels + compression + window(1 << 26, 0) + zero, "67108865 x 1 pixels"},
        {start + channels + compression + window(0, 5000) + zero, "cannot hold 5001 chunks"},
        {start + channels + attribute("compression", "compression", "\x09") + window(1 << 20, 0) +
             std::string(1000, '\0'),
         "chunks of 1048577 x 256 pixels"},
        {start + channels + attribute("compression", "compression", "\x0a") + window(0, 0) + zero,
         "compression 10"},
        {start + channels + compression + window(0, 0) +
             attribute("chunkCount", "int", number(2147483647)) + zero,
         "cannot hold 2147483647 chunks"},
        {tiled_start + channels + compression + window(3, 3) + zero, "has no attribute tiles"},
        {tiled_start + channels + compression + window(3, 3) + tiles(30000, 30000) + zero,
         "chunks of 30000 x 30000 pixels"},
        {tiled_start + channels + compression + window(999, 999) + tiles(1, 1) + zero,
         "cannot hold 1000000 chunks"},
        {tiled_start + channels + compression + window(3, 3) + tiles(0, 1) + zero,
         "attribute 'tiles'"},
        {parts_start + channels + compression + window(3, 3) + zero + huge_attribute,
         "part 1: attribute 'a': byte"},
    };
    for (const auto& [bytes, problem] : files) {
        test::write_file(path, bytes);
        const std::string message = test::complaint([&] { read_exr_parts(path); });
        EXPECT_NE(message.find(problem), std::string::npos) << message;
        EXPECT_EQ(message.find(path + ": "), 0U) << message;
    }
    // The file of 21 bytes takes no memory of its own.
    test::write_file(path, files[0].first);
    EXPECT_EQ(std::filesystem::file_size(path), 21U);
#ifndef __SANITIZE_ADDRESS__ // which needs all addresses
    const auto refuse_in_little_memory = [&] {
        test::limit_memory(std::size_t{1} << 26);
        std::exit(refused(path, read_exr) ? 0 : 1);
    };
    EXPECT_EXIT(refuse_in_little_memory(), testing::ExitedWithCode(0), "");
#endif
}

TEST(Exr, tiles_and_long_names_are_read) {
    const TemporaryFolder folder;
    const std::string path = folder / "a.exr";
    Image image = noise(37, 21);
    image.metadata[std::string(200, 'm')] = std::string(100000, 'x');
    write_exr(image, path, ExrPixel::Float);
    EXPECT_EQ(read_exr(path).metadata, image.metadata);

    Imf::Header header(37, 21);
    header.setTileDescription(Imf::TileDescription(64, 16, Imf::MIPMAP_LEVELS));
    header.channels().insert("R", Imf::Channel(Imf::FLOAT));
    {
        Imf::TiledOutputFile file(path.c_str(), header);
        for (int level = 0; level < file.numLevels(); ++level) {
            std::vector<float> small(37 * 21);
            Imf::FrameBuffer of_level;
            of_level.insert("R", Imf::Slice::Make(
                                     Imf::FLOAT, level == 0 ? image.planes[0].data() : small.data(),
                                     file.dataWindowForLevel(level)));
            file.setFrameBuffer(of_level);
            file.writeTiles(0, file.numXTiles(level) - 1, 0, file.numYTiles(level) - 1, level);
        }
    }
    EXPECT_EQ(read_exr(path).planes[0], image.planes[0]);
}

TEST(Png, values_are_linear_light) {
    const TemporaryFolder folder;
    const std::string path = folder / "a.png";
    const std::uint8_t grey[] = {0, 128, 255, 10};
    write_png(path, 2, 2, PNG_FORMAT_GRAY, grey);
    Image image = read_image(path);
    ASSERT_EQ(image.channels, std::vector<std::string>{"Y"});
    for (std::size_t i = 0; i < 4; ++i) {
        const double s = grey[i] / 255.0; // IEC 61966-2-1
        const double linear = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
        EXPECT_NEAR(image.planes[0][i], linear, 1e-6);
    }
    const std::uint16_t colour[] = {0, 30000, 65535, 1, 2, 3};
    write_png(path, 2, 1, PNG_FORMAT_LINEAR_RGB, colour);
    image = read_image(path);
    ASSERT_EQ(image.channels, (std::vector<std::string>{"R", "G", "B"}));
    for (std::size_t i = 0; i < 6; ++i)
        EXPECT_NEAR(image.planes[i % 3][i / 3], colour[i] / 65535.0, 1.5 / 65535);
}

TEST(Png, is_read_as_it_was_written) {
    const TemporaryFolder folder;
    const std::string path = folder / "a.png";
    Image image{2, 2, {"R", "G", "B"}, {}, {}};
    image.planes = {{0, 0.25F, 0.5F, 1}, {1, 2, -1, 0.1F}, {std::nanf(""), 0.01F, 0.02F, 0.9F}};
    write_png(image, path);
    const Image back = read_png(path);
    ASSERT_EQ(back.channels, image.channels);
    for (std::size_t ch = 0; ch < 3; ++ch)
        for (std::size_t i = 0; i < 4; ++i) {
            const float value = image.planes[ch][i];
            const float expected = value > 0 ? std::min(value, 1.0F) : 0.0F;
            EXPECT_NEAR(back.planes[ch][i], expected, 0.005) << ch << i;
        }
    image.planes.pop_back();
    EXPECT_THROW(write_png(image, path), UsageError);
    EXPECT_THROW(write_png(back, folder / "missing/a.png"), InputError);
}

TEST(Png, broken_files_are_errors) {
    const TemporaryFolder folder;
    const std::string path = folder / "a.png";
    std::vector<std::uint8_t> values(64 * 64);
    std::mt19937 random(3);
    for (std::uint8_t& value : values)
        value = static_cast<std::uint8_t>(random());
    write_png(path, 64, 64, PNG_FORMAT_GRAY, values.data());
    const std::string whole = test::read_file(path);
    for (std::size_t k = 0; k < 40; ++k) {
        test::write_file(path, whole.substr(0, whole.size() * k / 40));
        EXPECT_TRUE(refused(path, read_png)) << k;
    }
    test::write_file(path, whole);
    EXPECT_GT(refused_of_damaged(path, read_png, 60, 400), 100);
    std::string large = whole;
    large[16] = 0x40; // width
    test::write_file(path, large);
    EXPECT_TRUE(refused(path, read_png));
    test::write_file(path, "neither");
    EXPECT_TRUE(refused(path, read_image));
}

// A column of very many values stays a picture.
TEST(Preview, is_of_a_size_to_look_at) {
    const TemporaryFolder folder;
    std::vector<float> ramp(100000);
    for (std::size_t i = 0; i < ramp.size(); ++i)
        ramp[i] = static_cast<float>(i);
    const std::string seen = write_preview(
        {{"ramp", 1, ramp.size(), ramp}, {"zero", 2, 2, {0, -1, 0, 0}}}, folder / "p.png");
    EXPECT_EQ(seen, "from left to right ramp (white 1e+05), zero (white 0)");
    const Image picture = read_png(folder / "p.png");
    EXPECT_EQ(picture.width, 256U + 8 + 256);
    EXPECT_EQ(picture.height, 2048U);
    EXPECT_NEAR(picture.planes[0][1024 * picture.width], 0.5, 0.01);
    EXPECT_EQ(picture.planes[0][picture.width - 1], 0);
    EXPECT_THROW(write_preview({{"zero", 1, 1, {0}}}, folder / "p.jpg"), UsageError);
}

namespace {

Curve curve_of(const std::string& name, double level) {
    Curve curve{name, {}, {}};
    for (int k = 0; k <= 90; ++k) {
        curve.x.push_back(k);
        curve.y.push_back(level);
    }
    return curve;
}

std::string plotted(const std::vector<Curve>& curves, double top = 0) {
    const TemporaryFolder folder;
    write_plot(curves, {"Albedos", "directional albedo", "a -- b", top}, folder / "p.svg");
    return test::read_file(folder / "p.svg");
}

std::size_t count(const std::string& text, const std::string& part) {
    std::size_t found = 0;
    for (std::size_t at = text.find(part); at != std::string::npos; at = text.find(part, at + 1))
        ++found;
    return found;
}

/// The y of the tick with that text.
double tick(const std::string& svg, const std::string& text) {
    const std::size_t label = svg.find("end\">" + text + "</text>");
    if (label == std::string::npos)
        return std::nan("");
    const std::size_t path = svg.rfind("<path d=\"M", label);
    return std::stod(svg.substr(svg.find(' ', path + 8)));
}

} // namespace

TEST(Plot, has_titles_and_round_ticks) {
    const std::string svg = plotted({curve_of("a", 0.83)});
    EXPECT_EQ(count(svg, ">angle from the normal (degrees)<"), 1U);
    EXPECT_EQ(count(svg, ">directional albedo<"), 1U);
    EXPECT_EQ(count(svg, "--"), 2U); // those of the comment's ends
    for (const char* text : {"0", "0.2", "0.4", "0.6", "0.8", "1"})
        EXPECT_TRUE(std::isfinite(tick(svg, text))) << text;
    EXPECT_EQ(count(svg, "class=\"cut\""), 0U);
    // A large number and a small one.
    EXPECT_TRUE(std::isfinite(tick(plotted({curve_of("a", 730)}), "600")));
    EXPECT_TRUE(std::isfinite(tick(plotted({curve_of("a", 0.0021)}), "0.002")));
}

TEST(Plot, is_not_flattened_by_a_spike) {
    Curve spiked = curve_of("spiked", 0.5);
    spiked.y[90] = 40;
    spiked.y[89] = 30;
    Curve endless = curve_of("endless", 0.25);
    endless.y[90] = std::numeric_limits<double>::infinity();
    const std::string svg = plotted({curve_of("flat", 0.5), spiked, endless});
    // 0.5 is more than half of the picture up.
    EXPECT_GT(tick(svg, "0") - tick(svg, "0.4"), 0.4 * 240);
    EXPECT_EQ(count(svg, "class=\"cut\""), 2U);
    EXPECT_NE(svg.find(">spiked, up to 40<"), std::string::npos);
    EXPECT_NE(svg.find(">endless, up to infinity<"), std::string::npos);
    EXPECT_NE(svg.find(">flat<"), std::string::npos);
    // As large as is asked for.
    EXPECT_EQ(count(plotted({spiked}, 50), "class=\"cut\""), 0U);
    EXPECT_EQ(count(plotted({spiked}, 0.4), "class=\"cut\""), 1U);
}

TEST(Plot, tells_paths_apart) {
    EXPECT_EQ(distinct_names({"x/a.json", "x/b.binary"}), (std::vector<std::string>{"a", "b"}));
    EXPECT_EQ(distinct_names({"a.json", "a.binary", "b.csv"}),
              (std::vector<std::string>{"a.json", "a.binary", "b"}));
    EXPECT_EQ(distinct_names({"/r/x/a.json", "/r/y/a.json", "a.json"}),
              (std::vector<std::string>{"x/a.json", "y/a.json", "a.json"}));
    EXPECT_EQ(distinct_names({"p/x/a.json", "q/x/a.json"}),
              (std::vector<std::string>{"p/x/a.json", "q/x/a.json"}));
    EXPECT_EQ(distinct_names({"a.json", "a.json"}), (std::vector<std::string>{"a", "a (2)"}));
}
