// Measurements and materials written as .npz, ASTM, Zemax, Klems and MERL files: what is read again
// is what was written, and broken archives are refused by name.

#include "host/evaluate/evaluate.hpp"
#include "host/evaluate/klems.hpp"
#include "host/evaluate/measured.hpp"
#include "host/evaluate/rgl.hpp"
#include "host/evaluate/synthesise.hpp"
#include "host/files/npy.hpp"
#include "host/files/zip.hpp"
#include "host/measured/formats.hpp"
#include "host/measured/merl.hpp"
#include "host/measured/rgl.hpp"
#include "host/measured/write.hpp"
#include "tests/support/bad_files.hpp"
#include "tests/support/measured.hpp"
#include "tests/support/pairs.hpp"
#include "tests/support/rgl.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <fmt/format.h>
#include <sstream>
#include <zlib.h>

namespace brdfit {

namespace {

using test::changed;
using test::complaint;
using test::expect_complaint;
using test::read_file;
using test::run_program;
using test::write_file;

const std::string paint = R"({"brdfit": 1, "channels": ["R", "G", "B"],
    "diffuse": {"model": "lambert", "kd": [0.1, 0.2, 0.3]},
    "lobes": [{"model": "ggx", "ks": [0.5, 0.4, 0.3], "f0": 0.05, "a": 0.3}]})";
const std::string brushed = changed(paint, "\"a\": 0.3", "\"ax\": 0.2, \"ay\": 0.35");

class Written : public test::Measured {
  protected:
    std::string in(const std::string& name) const { return folder / name; }

    Material material(const std::string& text, const std::string& name = "m.json") {
        write_file(in(name), text);
        return read_material(in(name));
    }
    Samples measured(const std::string& text, std::size_t count = 500) {
        const Material of = material(text);
        return synthesise(test::device(), of, random_directions(count, of.isotropic(), 1), 0, 1);
    }
    void convert(const std::vector<std::string>& arguments) const {
        std::vector<std::string> all{"convert"};
        all.insert(all.end(), arguments.begin(), arguments.end());
        const auto outcome = run_program(all);
        ASSERT_EQ(outcome.status, 0) << outcome.err;
    }
    static void expect_same(const Samples& a, const Samples& b, float tolerance) {
        ASSERT_EQ(a.count(), b.count());
        EXPECT_EQ(a.channels, b.channels);
        EXPECT_EQ(a.isotropic, b.isotropic);
        for (std::size_t i = 0; i < a.values.size(); ++i)
            ASSERT_EQ(a.values[i], b.values[i]) << i;
        for (std::size_t k = 0; k < a.count(); ++k) {
            const auto [wi_a, wo_a] = a.directions->pair(k);
            const auto [wi_b, wo_b] = b.directions->pair(k);
            ASSERT_NEAR(test::dot(wi_a, wo_a), test::dot(wi_b, wo_b), tolerance) << k;
            ASSERT_NEAR(wi_a[2], wi_b[2], tolerance) << k;
        }
    }
};

// .npz

TEST_F(Written, npz_is_read_again) {
    for (const std::string& text : {paint, brushed}) {
        Samples samples = measured(text);
        samples.channels = {"red", "470 nm", "gr\u00fcn"};
        samples.weights.assign(samples.count(), 1);
        samples.weights[3] = 0.25F;
        samples.valid[5] = 0;
        write_samples(samples, in("s.npz"));
        const Samples again = read_samples(in("s.npz"));
        EXPECT_EQ(again.format, "NumPy archive");
        EXPECT_EQ(again.channels, samples.channels);
        EXPECT_EQ(again.isotropic, samples.isotropic);
        ASSERT_EQ(again.count(), samples.count() - 1) << "without the invalid one";
        EXPECT_EQ(again.weights[3], 0.25F);
        EXPECT_EQ(again.values[5], samples.values[6]);
        write_samples(again, in("again.npz"));
        expect_same(read_samples(in("again.npz")), again, 1e-6F);
    }
}

/// An archive whose members are deflated, without zip64, as other programs write them.
std::string deflated(const std::vector<std::pair<std::string, std::string>>& members) {
    const auto put = [](std::string& to, std::size_t value, int bytes) {
        for (int i = 0; i < bytes; ++i)
            to += static_cast<char>(value >> 8 * i & 0xff);
    };
    std::string bytes, directory;
    for (const auto& [name, data] : members) {
        std::string packed(compressBound(data.size()), '\0');
        uLongf size = packed.size();
        compress2(reinterpret_cast<Bytef*>(packed.data()), &size,
                  reinterpret_cast<const Bytef*>(data.data()), data.size(), 9);
        packed = packed.substr(2, size - 6); // without zlib's head and checksum
        std::string shared;
        put(shared, 20, 2);
        put(shared, 0, 2);
        put(shared, 8, 2);
        put(shared, 0, 4);
        put(shared,
            crc32(0, reinterpret_cast<const Bytef*>(data.data()), static_cast<uInt>(data.size())),
            4);
        put(shared, packed.size(), 4);
        put(shared, data.size(), 4);
        put(shared, name.size(), 2);
        put(shared, 0, 2); // extra
        directory += "PK\x01\x02";
        put(directory, 20, 2);
        directory += shared;
        directory.append(10, '\0'); // comment, disk, attributes
        put(directory, bytes.size(), 4);
        directory += name;
        bytes += "PK\x03\x04" + shared + name + packed;
    }
    std::string end = "PK\x05\x06";
    put(end, 0, 4);
    put(end, members.size(), 2);
    put(end, members.size(), 2);
    put(end, directory.size(), 4);
    put(end, bytes.size(), 4);
    put(end, 0, 2);
    return bytes + directory + end;
}

std::string array(const std::vector<std::size_t>& shape, const std::vector<double>& values) {
    return npy::header(shape, "<f8") +
           std::string(reinterpret_cast<const char*>(values.data()), values.size() * 8);
}

using Members = std::vector<std::pair<std::string, std::string>>;
const Members two_samples = {{"wi.npy", array({2, 3}, {0, 0, 1, 0.6, 0, 0.8})},
                             {"wo.npy", array({2, 3}, {0, 0.6, 0.8, -0.6, 0, 0.8})},
                             {"values.npy", array({2}, {0.5, 0.25})}};

TEST_F(Written, npz_of_others_is_read) {
    const Samples samples = read(deflated(two_samples));
    EXPECT_EQ(samples.values, (std::vector<float>{0.5, 0.25}));
    EXPECT_TRUE(samples.weights.empty());
    EXPECT_TRUE(samples.isotropic);
    EXPECT_NEAR(samples.directions->wo(0)[1], 0.6, 1e-6);
    Members more = two_samples;
    more[2].second = array({2, 2}, {1, 2, 3, 4});
    more.emplace_back("weights.npy", array({2}, {0.5, 2}));
    more.emplace_back("channels.npy", npy::header({2}, "|S5") + std::string("blue\0green", 10));
    more.emplace_back("note.txt", "anything");
    const Samples named = read(deflated(more));
    EXPECT_EQ(named.channels, (std::vector<std::string>{"blue", "green"}));
    EXPECT_EQ(named.values, (std::vector<float>{1, 3, 2, 4}));
    EXPECT_EQ(named.weights, (std::vector<float>{0.5, 2}));
}

TEST_F(Written, broken_npz_is_named) {
    const std::string path = in("file");
    const auto refused = [&](const std::string& bytes, const std::string& part) {
        write_file(path, bytes);
        expect_complaint(complaint([&] { read_samples(path); }), path, part);
    };
    const std::string good = deflated(two_samples);
    const std::size_t entry = good.find("PK\x01\x02"), end = good.find("PK\x05\x06");
    using namespace std::string_literals;
    const auto with = [&](std::size_t at, const std::string& patch) {
        return std::string(good).replace(at, patch.size(), patch);
    };
    ASSERT_NO_THROW(read(good));
    refused(with(entry + 10, "\x0c\x00"s), "packed by method 12; expected 0 (stored) or 8");
    refused(with(entry + 8, "\x01"), "it is encrypted");
    refused(with(entry + 16, "\x01\x02\x03\x04"), "its checksum does not agree");
    refused(with(entry + 20, "\xff\xff\xff\x7f"), "goes beyond its end");
    refused(with(entry + 24, "\xff\xff\xff\x7f"), "bytes cannot come of");
    refused(with(entry + 24, "\x10"), "cannot be unpacked to");
    refused(with(entry + 24, "\xff\xff\xff\xff"), "its zip64 field is missing");
    refused(with(entry + 42, "\x07"), "no member begins at byte 7");
    refused(with(end + 10, "\xff\x00"s), "255 members in a directory of");
    refused(with(end + 16, "\xff\xff\xff\x00"s), "the directory at byte");
    refused(good.substr(0, end), "no directory at its end");

    const auto without = [](const std::string& name) {
        Members members = two_samples;
        for (std::size_t i = 0; i < members.size(); ++i)
            if (members[i].first == name)
                members.erase(members.begin() + static_cast<std::ptrdiff_t>(i));
        return members;
    };
    const auto having = [&](const std::string& name, const std::string& bytes) {
        Members members = without(name);
        members.emplace_back(name, bytes);
        return deflated(members);
    };
    refused(deflated(without("values.npy")), "has no array values; expected wi, wo and values");
    refused(having("wo.npy", array({1, 3}, {0, 0, 1})), "wo: 1 x 3; expected 2 x 3");
    refused(having("wi.npy", array({2, 2}, {0, 0, 1, 1})), "wi: 2 x 2; expected 2 x 3");
    refused(having("values.npy", array({3}, {1, 2, 3})), "values: 3 x 1; expected 2 x 1");
    refused(having("values.npy", array({2, 0}, {})), "values: 2 x 0; expected 2 x 1");
    refused(having("values.npy", array({2}, {1, std::nan("")})), "expected a finite number");
    refused(having("values.npy", npy::header({2}, "<f4")), "0 bytes of data");
    refused(having("values.npy", "text"), "expected an array that NumPy wrote");
    refused(having("wi.npy", array({2, 3}, {0, 0, 0.5, 1, 0, 0})), "wi is not a unit vector");
    refused(having("weights.npy", array({2}, {1, -1})), "weight -1; expected 0 or more");
    refused(having("channels.npy", npy::texts({"R", "G"})), "2 names; expected 1");
    refused(having("channels.npy", npy::texts({"a,b"})), "a channel's name without commas");
    refused(having("channels.npy", array({1}, {1})), "expected texts");
    // A member that unpacks to a thousand times its size.
    refused(having("wi.npy", array({1000000, 3}, std::vector<double>(3000000))),
            "wo: 2 x 3; expected 1000000 x 3");
}

TEST_F(Written, npz_cut_and_mutated_is_read_or_refused) {
    const std::string path = in("file");
    write_samples(measured(paint, 3), in("s.npz"));
    for (const std::string& example : {deflated(two_samples), read_file(in("s.npz"))}) {
        const auto expect_read_or_refused = [&](const std::string& bytes) {
            write_file(path, bytes);
            Samples samples;
            const std::string message = complaint([&] { samples = read_samples(path); });
            if (message.empty())
                test::expect_whole(samples, bytes);
            else
                EXPECT_EQ(message.find(path + ": "), 0U) << message;
        };
        for (std::size_t size = 1; size < example.size(); ++size)
            expect_read_or_refused(example.substr(0, size));
        test::Mutations mutations(example);
        for (int i = 0; i < 500; ++i)
            expect_read_or_refused(mutations.next());
    }
}

// Text

TEST_F(Written, astm_is_read_again) {
    for (const std::string& text : {paint, brushed}) {
        const Samples samples = measured(text);
        write_samples(samples, in("s.astm"), {"by a test"});
        const Samples again = read_samples(in("s.astm"));
        EXPECT_EQ(again.format, "ASTM E1392 text");
        expect_same(samples, again, 1e-6F);
    }
}

/// The numbers of a Zemax file's TIS lines.
std::vector<double> scatter_of(const std::string& bytes) {
    std::vector<double> scatter;
    for (std::size_t at = bytes.find("\nTIS\t"); at != bytes.npos;
         at = bytes.find("\nTIS\t", at + 1))
        scatter.push_back(std::stod(bytes.substr(at + 5)));
    return scatter;
}

TEST_F(Written, zemax_has_the_values_and_their_integrals) {
    const std::string one = R"({"brdfit": 1, "channels": ["650"],
        "diffuse": {"model": "lambert", "kd": [0.3]},
        "lobes": [{"model": "ggx", "ks": [0.5], "f0": 0.05, "a": 0.3}]})";
    for (const std::string& text : {one, changed(one, "\"a\": 0.3", "\"ax\": 0.2, \"ay\": 0.35")}) {
        const Material of = material(text);
        convert({in("m.json"), in("z.bsdf"), "--zemax"});
        const Samples samples = read_samples(in("z.bsdf"));
        EXPECT_EQ(samples.isotropic, of.isotropic());
        const std::vector<float> expected = evaluate(test::device(), of, *samples.directions);
        for (std::size_t k = 0; k < samples.count(); ++k)
            ASSERT_NEAR(samples.values[k], expected[k], 1e-4 * expected[k] + 1e-6) << k;
        // Each block's samples have the integral that its TIS line says.
        const zemax::Grid grid = zemax::written_grid(of.isotropic());
        const std::vector<double> scatter = scatter_of(read_file(in("z.bsdf")));
        ASSERT_EQ(scatter.size(), grid.blocks());
        EXPECT_EQ(samples.count() + samples.left_out, grid.blocks() * grid.block());
        EXPECT_GT(samples.count(), samples.left_out / 2);
        const std::vector<double> integrals = test::block_integrals(samples, [&](std::size_t k) {
            return (of.isotropic() ? 2.0 : 1.0) * samples.directions->wo(k)[2];
        });
        ASSERT_EQ(integrals.size(), scatter.size());
        for (std::size_t b = 0; b < grid.blocks(); b += 7)
            EXPECT_NEAR(integrals[b], scatter[b], 1e-3 * scatter[b]) << b;
        EXPECT_NEAR(scatter[0], 0.32, 0.02) << "kd and, about, ks f0";
    }
}

TEST_F(Written, zemax_has_x_y_and_z) {
    material(changed(paint, "\"ks\": [0.5, 0.4, 0.3]", "\"ks\": [0, 0, 0]"));
    convert({in("m.json"), in("z.bsdf"), "--zemax"});
    const Samples samples = read_samples(in("z.bsdf"));
    EXPECT_EQ(samples.channels, (std::vector<std::string>{"X", "Y", "Z"}));
    ASSERT_TRUE(samples.valid[0]);
    EXPECT_NEAR(samples.channel(1)[0] * pi, 0.2126729 * 0.1 + 0.7151522 * 0.2 + 0.0721750 * 0.3,
                1e-5);
    write_file(in("two.csv"), "theta_i,phi_i,theta_o,phi_o,a,b\n0.5,0,0.25,1,0.5,0.25\n");
    const auto outcome = run_program({"convert", in("two.csv"), in("two.bsdf"), "--zemax"});
    EXPECT_EQ(outcome.status, 1);
    EXPECT_NE(outcome.err.find("a Zemax file has one, or X, Y and Z"), std::string::npos);
    EXPECT_EQ(run_program({"convert", in("m.json"), in("z.csv"), "--zemax"}).status, 2);
    EXPECT_EQ(run_program({"convert", in("m.json"), in("z.bsdf"), "--zemax", "--spectral"}).status,
              2);
}

// Klems

TEST_F(Written, klems_matrix_conserves_what_is_reflected) {
    const std::vector<double> angles = klems::projected_solid_angles();
    ASSERT_EQ(angles.size(), klems::patches);
    double all = 0;
    for (const double angle : angles)
        all += angle;
    EXPECT_NEAR(all, pi, 1e-12);
    const Material of = material(paint);
    const BrdfFunction brdf = [&](const Directions& directions) {
        return evaluate(test::device(), of, directions);
    };
    const std::vector<double> matrix = klems::matrix(brdf, {0.2126, 0.7152, 0.0722});
    // Reciprocal, and brightest at the mirror direction, which has the same number.
    for (std::size_t out = 0; out < klems::patches; out += 3)
        for (std::size_t in = 0; in < out; ++in)
            ASSERT_NEAR(matrix[out * klems::patches + in], matrix[in * klems::patches + out],
                        0.01 * matrix[in * klems::patches + out])
                << out << " " << in;
    for (const auto& [in, begin, end] :
         {std::array{30U, 25U, 45U}, {60U, 45U, 69U}, {90U, 69U, 93U}})
        for (std::size_t out = begin; out < end; ++out) // of its ring
            EXPECT_LE(matrix[out * klems::patches + in], matrix[in * klems::patches + in]);
    double reflected = 0;
    for (std::size_t out = 0; out < klems::patches; ++out)
        reflected += matrix[out * klems::patches] * angles[out];
    // kd's luminance 0.186 and, about, ks f0.
    EXPECT_GT(reflected, 0.19);
    EXPECT_LT(reflected, 0.22);
}

TEST_F(Written, klems_file_holds_both_sides) {
    material(paint, "a & b.json");
    convert({in("a & b.json"), in("k.xml")});
    const std::string xml = read_file(in("k.xml"));
    EXPECT_NE(xml.find("<Name>a &amp; b</Name>"), std::string::npos);
    for (const char* side : {"Front", "Back"}) {
        const std::size_t block = xml.find(fmt::format("Reflection {}<", side));
        ASSERT_NE(block, std::string::npos);
        const std::size_t begin = xml.find("<ScatteringData>", block) + 16;
        std::string numbers = xml.substr(begin, xml.find('<', begin) - begin);
        std::replace(numbers.begin(), numbers.end(), ',', ' ');
        std::istringstream stream(numbers);
        std::size_t count = 0;
        for (double value; stream >> value; ++count)
            EXPECT_GE(value, 0);
        EXPECT_EQ(count, klems::patches * klems::patches);
        EXPECT_TRUE(stream.eof());
    }
    write_file(in("two.csv"), "theta_i,phi_i,theta_o,phi_o,a,b\n0.5,0,0.25,1,0.5,0.25\n");
    EXPECT_EQ(run_program({"convert", in("two.csv"), in("two.xml")}).status, 1);
    EXPECT_FALSE(std::filesystem::exists(in("two.xml")));
}

// Scattered samples to RGL

/// The errors that a line says: median and 95th percentile in per cent, after `what`.
std::array<double, 2> errors_in(const std::string& line, const std::string& what) {
    std::array<double, 2> errors{};
    const std::size_t at = line.find(what);
    EXPECT_NE(at, line.npos) << line;
    const std::string numbers = at == line.npos ? "" : line.substr(at + what.size());
    EXPECT_EQ(std::sscanf(numbers.c_str(), " %lf %% in the median, %lf", &errors[0], &errors[1]), 2)
        << line;
    return errors;
}

TEST_F(Written, tables_of_scattered_samples_are_better_than_what_is_between_those) {
    std::vector<std::string> files{in("s.csv")};
    write_samples(measured(paint, 4000), files[0]);
    if (!test::data_folder().empty()) // mirror peaks, falling to 0
        files.push_back((test::data_folder() / "cornell/cayman.brdf").string());
    for (const std::string& file : files) {
        const auto outcome = run_program({"convert", file, in("s.bsdf")});
        ASSERT_EQ(outcome.status, 0) << outcome.err;
        const auto table = errors_in(outcome.out, "relative error"),
                   data = errors_in(outcome.out, "which misses a sample that is left out by");
        EXPECT_LT(table[0], 0.7 * data[0]) << outcome.out;
        EXPECT_LT(table[1], 0.7 * data[1]) << outcome.out;
    }
}

// RGL to MERL

TEST_F(Written, rgl_goes_to_the_bins_of_merl_by_its_warp) {
    write_file(in("r.bsdf"), test::tensor_bytes(test::rgl_fields()));
    convert({in("r.bsdf"), in("r.binary")});
    const Samples merl = read_samples(in("r.binary"));
    const std::vector<float> expected =
        evaluate(test::device(), rgl::read_tables(MappedFile(in("r.bsdf"))), *merl.directions);
    std::size_t valid = 0;
    for (std::size_t k = 0; k < merl.count(); k += 11)
        if (merl.valid[k] != 0) {
            ++valid;
            // Below 0 is what a MERL file has not measured.
            ASSERT_NEAR(merl.values[k], std::max(expected[k], 0.0F), 1e-5 * std::abs(expected[k]));
        }
    EXPECT_GT(valid, merl.count() / 11 * 6 / 10);
    write_file(in("a.bsdf"), test::tensor_bytes(test::rgl_fields(3)));
    const auto outcome = run_program({"convert", in("a.bsdf"), in("a.binary")});
    EXPECT_EQ(outcome.status, 1);
    EXPECT_NE(outcome.err.find("a MERL file holds isotropic data"), std::string::npos);
}

} // namespace

} // namespace brdfit
