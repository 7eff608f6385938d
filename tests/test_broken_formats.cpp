// What is wrong with files of every format in the same way: cut, not the format at all, numbers as
// other countries write them, shapes that overflow. Each is read whole or refused by its name.

#include "host/files/npy.hpp"
#include "host/files/zip.hpp"
#include "host/measured/formats.hpp"
#include "host/measured/merl.hpp"
#include "host/measured/read.hpp"
#include "host/measured/write.hpp"
#include "tests/support/bad_files.hpp"
#include "tests/support/measured.hpp"
#include "tests/support/rgl.hpp"

#include <algorithm>
#include <fmt/format.h>
#include <gtest/gtest.h>
#include <map>
#include <zlib.h>

namespace brdfit {

namespace {

using test::complaint;
using test::write_file;

class BrokenFormats : public testing::Test {
  protected:
    const test::TemporaryFolder folder;
    const std::string path = folder / "file";

    /// Small whole files of text formats.
    const std::map<std::string, std::string> texts = {
        {"csv", test::csv_example},     {"astm", test::astm_example},
        {"zemax", test::zemax_example}, {"cornell", test::cornell_example},
        {"fred", test::fred_example},   {"alta", test::alta_example}};
    /// And of the others, but for those known by their size.
    std::map<std::string, std::string> binaries() const {
        const std::string csv = folder / "s.csv";
        write_file(csv, test::csv_example);
        const Samples samples = read_samples(csv);
        std::map<std::string, std::string> made{{"rgl", test::tensor_bytes(test::rgl_fields())}};
        for (const char* ending : {"npy", "npz"}) {
            const std::string file = folder / "s." + ending;
            write_samples(samples, file);
            made[ending] = test::read_file(file);
        }
        return made;
    }
    std::map<std::string, std::string> all() const {
        std::map<std::string, std::string> made = binaries();
        made.insert(texts.begin(), texts.end());
        return made;
    }

    std::string complaint_of(const std::string& bytes) const {
        write_file(path, bytes);
        return complaint([&] { read_samples(path); });
    }
    void refused(const std::string& name, const std::string& bytes, const std::string& part) {
        SCOPED_TRACE(name);
        test::expect_complaint(complaint_of(bytes), path, part);
    }
    void read_or_refused(const std::string& name, const std::string& bytes) {
        SCOPED_TRACE(name);
        write_file(path, bytes);
        Samples samples;
        const std::string message = complaint([&] { samples = read_samples(path); });
        if (message.empty())
            test::expect_whole(samples, name);
        else
            EXPECT_EQ(message.find(path + ": "), 0U) << message;
    }
};

/// As gzip packs it, but for the checksum at the end.
std::string gzip(const std::string& bytes) {
    std::string packed(compressBound(bytes.size()), '\0');
    uLongf size = packed.size();
    compress(reinterpret_cast<Bytef*>(packed.data()), &size,
             reinterpret_cast<const Bytef*>(bytes.data()), bytes.size());
    return std::string("\x1f\x8b\x08\0\0\0\0\0\0\x03", 10) + packed.substr(2, size - 6);
}

TEST_F(BrokenFormats, the_examples_are_whole) {
    for (const auto& [name, bytes] : all())
        EXPECT_EQ(complaint_of(bytes), "") << name;
}

TEST_F(BrokenFormats, what_is_compressed_or_a_page_is_named) {
    for (const auto& [name, bytes] : all())
        refused(name, gzip(bytes), "is compressed by gzip; expected it unpacked");
    for (const char* page :
         {"<!DOCTYPE html>\n<html><body>404</body></html>", "\xef\xbb\xbf<!doctype html>",
          "\r\n<HTML lang=\"en\">\r\n<head></head>"})
        refused(page, page, "is a page of the web (HTML); expected the file that it links to");
}

TEST_F(BrokenFormats, line_ends_and_marks_of_other_systems_change_nothing) {
    for (const auto& [name, text] : texts) {
        write_file(path, text);
        const Samples plain = read_samples(path);
        std::string changed = "\xef\xbb\xbf";
        for (const char c : text)
            changed += c == '\n' ? std::string("\r\n") : std::string(1, c);
        write_file(path, changed);
        const Samples same = read_samples(path);
        EXPECT_EQ(plain.values, same.values) << name;
        EXPECT_EQ(plain.channels, same.channels) << name;
        EXPECT_EQ(plain.directions->data(), same.directions->data()) << name;
    }
}

// Every number of the rows, from the last line upwards, in turn.
TEST_F(BrokenFormats, numbers_that_are_none_are_refused_with_their_line) {
    for (const auto& [name, text] : texts) {
        SCOPED_TRACE(name);
        const std::size_t begin =
            name == "zemax" ? text.rfind("\n4") + 1 : text.rfind('\n', text.size() - 2) + 1;
        const std::size_t end = text.find('\n', begin);
        std::vector<std::pair<std::size_t, std::size_t>> words; // begin, size
        for (std::size_t at = begin; at < end;) {
            const std::size_t next = std::min(text.find_first_of(" ,\t\n", at), end);
            words.emplace_back(at, next - at);
            at = next + 1;
        }
        ASSERT_GE(words.size(), 3U);
        for (const auto& [at, size] : words)
            for (const char* bad :
                 {"nan", "inf", "-inf", "1e999", "0x1p3", "1.5.2", "--1", "1e", "ten", "\xff"}) {
                std::string changed = text;
                changed.replace(at, size, bad);
                const std::string message = complaint_of(changed);
                EXPECT_EQ(message.find(path + ": "), 0U) << bad << " in " << changed;
                EXPECT_NE(message.find("line"), std::string::npos) << message;
            }
    }
}

TEST_F(BrokenFormats, decimal_commas_are_refused) {
    for (const auto& [name, text] : texts) {
        // Of the last line alone: headers name things.
        std::string changed = text;
        const std::size_t end = changed.find_last_of("0123456789");
        const std::size_t begin =
            name == "zemax" ? text.rfind("3 0.5 0.3") : changed.rfind('\n', end);
        const std::size_t dot = changed.find('.', begin);
        ASSERT_NE(dot, std::string::npos) << name;
        changed[dot] = ',';
        const std::string message = complaint_of(changed);
        EXPECT_EQ(message.find(path + ": "), 0U) << name << ": " << message;
    }
}

TEST_F(BrokenFormats, every_cut_is_read_or_refused) {
    for (const auto& [name, bytes] : all()) {
        const std::size_t step = std::max<std::size_t>(1, bytes.size() / 700);
        for (std::size_t size = 1; size < bytes.size(); size += step)
            read_or_refused(name, bytes.substr(0, size));
    }
}

// Of the formats that say how much there is, no part is taken for the whole.
TEST_F(BrokenFormats, no_cut_of_a_large_file_is_taken_for_the_whole) {
    constexpr std::size_t step = std::size_t{1} << 16;
    const auto samples = [](std::size_t count) {
        Samples made;
        made.channels = {"R", "G", "B"};
        const auto directions = std::make_shared<Directions>(count);
        for (std::size_t k = 0; k < count; ++k)
            directions->set(k, direction(0.5, 0), direction(0.1, static_cast<double>(k)));
        made.directions = directions;
        made.values.assign(3 * count, 0.25F);
        made.valid.assign(count, 1);
        return made;
    };
    for (const char* name : {"s.npy", "s.npz", "s.astm"}) {
        write_samples(samples(10000), folder / name);
        const std::string bytes = test::read_file(folder / name);
        ASSERT_GT(bytes.size(), 4 * step) << name;
        EXPECT_EQ(complaint_of(bytes), "") << name;
        for (std::size_t size = step; size < bytes.size(); size += step)
            EXPECT_NE(complaint_of(bytes.substr(0, size)), "") << name << " of " << size;
    }
    // Those known by their size, as holes: cut and too long.
    for (const std::size_t whole :
         {12 + 3 * merl::bins * sizeof(double),
          utia::channels * utia::directions * utia::directions * sizeof(double)}) {
        write_file(path, whole > std::size_t{1} << 24 ? test::merl_header(90, 90, 180) : "");
        for (const std::size_t size : {whole - 1, whole - step, whole / step * step,
                                       whole / 2 / step * step, step, whole + 1}) {
            std::filesystem::resize_file(path, size);
            EXPECT_NE(complaint([&] { read_samples(path); }), "") << size << " of " << whole;
        }
    }
}

TEST_F(BrokenFormats, real_files_cut_are_read_or_refused) {
    if (test::data_folder().empty())
        GTEST_SKIP() << "BRDFIT_DATA is not set";
    for (const char* name :
         {"rgl/chm_mint_rgb.bsdf", "cornell/acryl_blue.brdf", "cornell/garnet_red_RGB.astm",
          "ua-loft/processed__zemax__IMX455.bsdf", "alta/retro-gray-tape.dat"}) {
        const std::string bytes = test::read_file((test::data_folder() / name).string());
        constexpr std::size_t step = std::size_t{1} << 16;
        for (std::size_t size = step; size < bytes.size(); size += step)
            read_or_refused(name, bytes.substr(0, size));
    }
}

TEST_F(BrokenFormats, shapes_that_overflow_are_refused) {
    const std::string most = "18446744073709551615";
    const std::vector<std::string> shapes = {most + ", 8", "4611686018427387904, 8",
                                             "8, 4611686018427387904", most + "0, 8"};
    for (const std::string& shape : shapes) {
        const std::string header =
            "{'descr': '<f4', 'fortran_order': False, 'shape': (" + shape + "), }\n";
        const std::string bytes = test::npy_file(1, header, std::vector<float>(16));
        EXPECT_NE(complaint_of(bytes), "") << shape;
        zip::Writer writer(folder / "s.npz");
        writer.add("wi.npy", bytes, {});
        writer.commit();
        EXPECT_NE(complaint_of(test::read_file(folder / "s.npz")), "") << shape;
    }
    for (const char* key :
         {"SampleRotation\t2", "AngleOfIncidence\t2", "ScatterAzimuth\t3", "ScatterRadial\t3"}) {
        const std::string huge = std::string(key).substr(0, std::string(key).size() - 1);
        for (const std::string& count : {most, most + "0", std::string("-1"), std::string("3.5")})
            EXPECT_NE(complaint_of(test::changed(test::zemax_example, key, huge + count)), "")
                << key << count;
    }
    for (const std::string& count : {most, most + "0", std::string("-1")}) {
        EXPECT_NE(complaint_of(test::changed(test::cornell_example, "\n3\n", "\n" + count + "\n")),
                  "");
        EXPECT_NE(
            complaint_of(test::changed(test::astm_example, "NUM_POINTS 2", "NUM_POINTS " + count)),
            "");
        EXPECT_NE(complaint_of(test::changed(test::alta_example, "#DIM 3 1", "#DIM 3 " + count)),
                  "");
    }
}

} // namespace

} // namespace brdfit
