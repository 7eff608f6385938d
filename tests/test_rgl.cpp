// RGL files: the tables, the samples at their nodes, and the warp on the device against float64.

#include "host/evaluate/rgl.hpp"
#include "host/measured/read.hpp"
#include "tests/support/bad_files.hpp"
#include "tests/support/measured.hpp"
#include "tests/support/pairs.hpp"
#include "tests/support/rgl.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <fmt/format.h>
#include <limits>

namespace brdfit {

namespace {

using test::complaint;
using test::field_of;
using test::rgl_fields;
using test::TensorField;
using test::write_file;

class Rgl : public test::Measured {
  protected:
    const std::string path = folder / "rgl.bsdf";

    void write(const std::vector<TensorField>& fields) {
        write_file(path, test::tensor_bytes(fields));
    }
    RglTables tables() { return rgl::read_tables(MappedFile(path)); }
    /// What read_samples says of a file with these bytes; empty where it reads them.
    std::string complaint_of(const std::string& bytes) {
        write_file(path, bytes);
        return complaint([&] { read_samples(path); });
    }
    void refused(const std::vector<TensorField>& fields, const std::string& part) {
        test::expect_complaint(complaint_of(test::tensor_bytes(fields)), path, part);
    }
};

/// The files of the RGL database in the folder of measured data.
std::vector<std::string> real_files() {
    std::vector<std::string> files;
    if (!test::data_folder().empty())
        for (const auto& entry : std::filesystem::directory_iterator(test::data_folder() / "rgl"))
            if (entry.path().extension() == ".bsdf")
                files.push_back(entry.path().string());
    std::sort(files.begin(), files.end());
    return files;
}

std::vector<test::Pair> random_pairs(std::size_t count) {
    test::Random random(5);
    std::vector<test::Pair> pairs;
    while (pairs.size() < count) {
        pairs.push_back(test::random_pair(random));
        if (pairs.back().wi[2] < 1e-3 || pairs.back().wo[2] < 1e-3)
            pairs.pop_back();
    }
    return pairs;
}

/// Compares the device with the float64 reference; values below `floor` by their difference.
void expect_reference(const std::string& file, const std::vector<test::Pair>& pairs, double floor) {
    const RglTables tables = rgl::read_tables(MappedFile(file));
    const std::vector<TensorField> fields = test::read_fields(test::read_file(file));
    const std::vector<float> values = evaluate(test::device(), tables, test::directions_of(pairs));
    ASSERT_EQ(values.size(), tables.channels.size() * pairs.size());
    test::Mismatches mismatches;
    for (std::size_t k = 0; k < pairs.size(); ++k) {
        const std::vector<double> f = test::rgl_reference(fields, pairs[k].wi, pairs[k].wo);
        for (std::size_t ch = 0; ch < f.size(); ++ch)
            mismatches.check_near(file + " " + tables.channels[ch], pairs[k],
                                  values[ch * pairs.size() + k], f[ch],
                                  2e-3 * std::max(std::abs(f[ch]), floor));
    }
}

TEST_F(Rgl, device_follows_the_definition) {
    for (const auto& fields : {rgl_fields(), rgl_fields(2), rgl_fields(5, 2 * pi),
                               rgl_fields(4, pi), rgl_fields(3, pi / 2), rgl_fields(1, 0, 7)}) {
        write(fields);
        expect_reference(path, random_pairs(2000), 0.01);
    }
    std::vector<TensorField> plain = rgl_fields();
    field_of(plain, "jacobian").values = {0};
    write(plain);
    expect_reference(path, random_pairs(200), 0.01);
}

TEST_F(Rgl, axes_belong_to_the_part_of_the_circle_that_a_file_has) {
    for (const double turn : {pi, pi / 2}) {
        write(rgl_fields(3, turn));
        std::vector<test::Pair> pairs;
        for (const Vector& wi : {Vector{0.6, 0, 0.8}, Vector{-0.6, 0, 0.8}})
            pairs.push_back({wi, {0.36, 0.48, 0.8}});
        expect_reference(path, pairs, 0.01);
    }
}

TEST_F(Rgl, special_directions_have_finite_values) {
    write(rgl_fields(3, pi));
    std::vector<test::Pair> pairs = test::special_pairs();
    pairs.push_back({{0, 0, 1}, {0.6, 0, -0.8}});
    const RglTables read = tables();
    const std::vector<float> values = evaluate(test::device(), read, test::directions_of(pairs));
    for (const float value : values)
        EXPECT_TRUE(std::isfinite(value));
    for (std::size_t ch = 0; ch < 3; ++ch)
        EXPECT_EQ(values[(ch + 1) * pairs.size() - 1], 0) << "below the horizon";
}

TEST_F(Rgl, real_files_follow_the_definition) {
    if (real_files().empty())
        GTEST_SKIP() << "BRDFIT_DATA is not set";
    for (const std::string& file : real_files())
        expect_reference(file, random_pairs(200), 1e-3);
}

// The stored values have a cosine: without it the measurements are reciprocal, as far as noise lets
// them.
TEST_F(Rgl, real_files_are_reciprocal) {
    if (real_files().empty())
        GTEST_SKIP() << "BRDFIT_DATA is not set";
    std::vector<test::Pair> pairs = random_pairs(4000), turned;
    const double least = std::cos(80 * degree);
    pairs.erase(std::remove_if(pairs.begin(), pairs.end(),
                               [&](const test::Pair& pair) {
                                   return pair.wi[2] < least || pair.wo[2] < least;
                               }),
                pairs.end());
    for (const test::Pair& pair : pairs)
        turned.push_back({pair.wo, pair.wi});
    const auto median = [](std::vector<double> x) {
        const auto middle = x.begin() + static_cast<std::ptrdiff_t>(x.size() / 2);
        std::nth_element(x.begin(), middle, x.end());
        return *middle;
    };
    std::vector<double> medians, with_cosine; // a file each
    for (const std::string& file : real_files()) {
        const RglTables tables = rgl::read_tables(MappedFile(file));
        const auto green = [&](const std::vector<test::Pair>& at) {
            const std::vector<float> values =
                evaluate(test::device(), tables, test::directions_of(at));
            const auto begin = values.begin() + static_cast<std::ptrdiff_t>(at.size());
            return std::vector<double>(begin, begin + static_cast<std::ptrdiff_t>(at.size()));
        };
        const std::vector<double> there = green(pairs), back = green(turned);
        std::vector<double> errors, errors_with;
        const auto difference = [](double a, double b) {
            return std::abs(a - b) / std::max(std::abs(a) + std::abs(b), 1e-9) * 2;
        };
        for (std::size_t k = 0; k < pairs.size(); ++k) {
            errors.push_back(difference(there[k], back[k]));
            errors_with.push_back(difference(there[k] * pairs[k].wo[2], back[k] * pairs[k].wi[2]));
        }
        medians.push_back(median(errors));
        with_cosine.push_back(median(errors_with));
    }
    EXPECT_LT(*std::min_element(medians.begin(), medians.end()), 0.03);
    EXPECT_LT(median(medians), 0.2);
    EXPECT_GT(median(with_cosine), 2 * median(medians));
}

TEST_F(Rgl, nodes_have_the_tabulated_values) {
    std::vector<std::string> files = real_files();
    for (const auto& fields : {rgl_fields(), rgl_fields(5, 2 * pi), rgl_fields(1, 0, 7)}) {
        files.push_back(folder / fmt::format("{}.bsdf", files.size()));
        write_file(files.back(), test::tensor_bytes(fields));
    }
    for (const std::string& file : files) {
        const RglTables tables = rgl::read_tables(MappedFile(file));
        const Samples samples = read_samples(file);
        test::expect_whole(samples, file);
        EXPECT_EQ(samples.count() + samples.left_out, tables.slices() * tables.table.count());
        EXPECT_EQ(samples.channels, tables.channels);
        EXPECT_EQ(samples.isotropic, tables.isotropic());
        const std::vector<float> values = evaluate(test::device(), tables, *samples.directions);
        // The table's first and last row are one azimuth, its first column is the normal alone; so
        // are slices of wi.
        const auto unique = [&](std::size_t k) {
            const auto plane = [&](Directions::Plane p) { return samples.directions->plane(p)[k]; };
            const auto turned_back = [](double azimuth) { return std::cos(azimuth) < -1 + 1e-9; };
            const double phi_h = std::atan2(plane(Directions::HY), plane(Directions::HX)),
                         phi_i = std::atan2(plane(Directions::WiY), plane(Directions::WiX));
            if (1 - plane(Directions::HZ) < 1e-9)
                return false;
            if (!tables.isotropic())
                return !turned_back(phi_h) && !turned_back(phi_i) &&
                       1 - plane(Directions::WiZ) > 1e-9;
            return std::none_of(tables.phi_i.begin(), tables.phi_i.end(),
                                [&](float phi) { return turned_back(phi_h - phi); });
        };
        // Where the density is small one step of float32 is far on the table.
        std::size_t off = 0, looked_at = 0;
        for (std::size_t i = 0; i < values.size(); ++i)
            if (unique(i % samples.count())) {
                const double value = samples.values[i];
                off += std::abs(values[i] - value) > 1e-3 * std::max(std::abs(value), 1e-3);
                ++looked_at;
            }
        EXPECT_GT(looked_at, (values.size() + samples.left_out * samples.channels.size()) / 8)
            << file;
        EXPECT_LE(static_cast<double>(off), 0.002 * static_cast<double>(looked_at)) << file;
    }
}

// Weights are solid angles: integrals over the samples are those over the hemispheres.
TEST_F(Rgl, weights_are_solid_angles) {
    std::vector<TensorField> fields = rgl_fields();
    field_of(fields, "vndf").shape = {1, 8, 17, 9};
    field_of(fields, "theta_i").shape = {8};
    field_of(fields, "theta_i").values = {0, 0.2F, 0.4F, 0.6F, 0.8F, 1, 1.2F, 1.4F};
    field_of(fields, "rgb").shape = {1, 8, 3, 64, 64};
    field_of(fields, "luminance").shape = {1, 8, 64, 64};
    for (const char* name : {"vndf", "rgb", "luminance"}) {
        TensorField& field = field_of(fields, name);
        field.values.resize(field.count());
        for (std::size_t i = 0; i < field.values.size(); ++i)
            field.values[i] = 1 + 0.5F * std::sin(static_cast<float>(i % 153));
    }
    write(fields);
    const Samples samples = read_samples(path);
    double sum = 0, both = 0;
    for (std::size_t k = 0; k < samples.count(); ++k)
        if (samples.valid[k] != 0) {
            sum += samples.weights[k] * samples.directions->wo(k)[2];
            both +=
                samples.weights[k] * samples.directions->wi(k)[2] * samples.directions->wo(k)[2];
        }
    EXPECT_NEAR(sum / (2 * pi * pi), 1, 0.03);
    EXPECT_NEAR(both / (pi * pi), 1, 0.03);
}

TEST_F(Rgl, what_is_written_is_read_again) {
    for (const auto& fields : {rgl_fields(), rgl_fields(4, pi, 7)}) {
        write(fields);
        const RglTables before = tables();
        EXPECT_EQ(before.description, "test");
        rgl::write(before, folder / "again.bsdf");
        const std::vector<TensorField> again =
            test::read_fields(test::read_file(folder / "again.bsdf"));
        ASSERT_EQ(again.size(), fields.size());
        for (TensorField field : again) {
            const TensorField& expected =
                field_of(const_cast<std::vector<TensorField>&>(fields), field.name);
            EXPECT_EQ(field.shape, expected.shape) << field.name;
            EXPECT_EQ(field.values, expected.values) << field.name;
            EXPECT_EQ(field.type, expected.type) << field.name;
        }
    }
}

TEST_F(Rgl, isotropy_is_the_files) {
    write(rgl_fields());
    EXPECT_THROW(read_samples(path, false), UsageError);
    EXPECT_TRUE(read_samples(path, true).isotropic);
    write(rgl_fields(3));
    EXPECT_THROW(read_samples(path, true), UsageError);
    EXPECT_FALSE(read_samples(path).isotropic);
}

TEST_F(Rgl, every_cut_is_refused) {
    const std::string bytes = test::tensor_bytes(rgl_fields());
    ASSERT_EQ(complaint_of(bytes), "");
    for (std::size_t size = 11; size < bytes.size(); size += size < 1000 ? 1 : 101)
        test::expect_complaint(complaint_of(bytes.substr(0, size)), path, "byte");
    if (real_files().empty())
        GTEST_SKIP() << "BRDFIT_DATA is not set";
    const std::string real = test::read_file(real_files()[0]);
    for (std::size_t size = std::size_t{1} << 16; size < real.size(); size += std::size_t{1} << 16)
        test::expect_complaint(complaint_of(real.substr(0, size)), path, "field '");
}

TEST_F(Rgl, the_header_is_named_by_byte) {
    const std::string bytes = test::tensor_bytes(rgl_fields());
    const auto with = [&](std::size_t at, std::string_view patch) {
        std::string changed = bytes;
        changed.replace(at, patch.size(), patch);
        return complaint_of(changed);
    };
    const auto expects = [&](const std::string& message, const std::string& part) {
        test::expect_complaint(message, path, part);
    };
    using namespace std::string_view_literals;
    expects(with(11, "!"), "header: byte 12: no tensor file");
    expects(with(12, "\2\0"sv), "version 2.0; expected 1.0");
    expects(with(14, "\xff\xff\xff\xff"), "4294967295 fields; expected at most 256");
    expects(with(14, "\x20\0\0\0"sv), "field ");
    // The first field: its name's length at 18, its name to 31, dimensions, type, offset, shape.
    expects(with(18, "\xff\xff"), "field 1 of 9: byte 20: the file ends within the name");
    expects(with(31, "\x09\0"sv), "field 'description': byte 33: 9 dimensions");
    for (const char type : {'\0', '\x0c', '\xff'})
        expects(with(33, {&type, 1}), "; expected 1 to 11");
    expects(with(33, "\x0a"), "field 'description' at byte");
    expects(with(34, "\xff\xff\xff\xff\xff\xff\xff\xff"), "end after the file's");
    expects(with(42, "\xff\xff\xff\xff\xff\xff\xff\xff"), "the file holds");
    expects(with(42, "\0\0\0\0\0\0\0\x40"sv), "the file holds");
}

TEST_F(Rgl, fields_are_named) {
    for (const TensorField& field : rgl_fields()) {
        std::vector<TensorField> fields = rgl_fields();
        field_of(fields, field.name).name = "other";
        refused(fields, field.name == "rgb" ? "no field 'rgb'"
                                            : "no field '" + field.name + "'; expected an RGL");
        fields = rgl_fields();
        fields.push_back(field);
        refused(fields, "a second field of this name");
        fields = rgl_fields();
        field_of(fields, field.name).type = field.type == 1 ? 10 : 1;
        refused(fields, fmt::format("field '{}' at byte", field.name));
        fields = rgl_fields();
        field_of(fields, field.name).shape.push_back(1);
        refused(fields, "dimensions; expected");
        if (field.name == "description")
            continue;
        fields = rgl_fields();
        field_of(fields, field.name).shape[0] = 0;
        refused(fields, fmt::format("field '{}'", field.name));
    }
    std::vector<TensorField> fields = rgl_fields(1, 0, 7);
    field_of(fields, "wavelengths").name = "other";
    refused(fields, "no field 'wavelengths'");
}

TEST_F(Rgl, values_are_named_by_byte) {
    const float infinity = std::numeric_limits<float>::infinity();
    for (const TensorField& field : rgl_fields())
        if (field.type == 10)
            for (const float value : {infinity, -infinity, std::nanf("")}) {
                std::vector<TensorField> fields = rgl_fields();
                field_of(fields, field.name).values.back() = value;
                refused(fields, fmt::format("field '{}', byte ", field.name));
            }
    const auto with = [&](const char* name, std::size_t i, float value, const char* part) {
        std::vector<TensorField> fields = rgl_fields();
        field_of(fields, name).values[i] = value;
        refused(fields, part);
    };
    with("theta_i", 1, 1.2F, "byte 384: 1; expected values that ascend");
    with("theta_i", 3, 1.7F, "1.7; expected an angle in [0, pi/2]");
    with("theta_i", 0, -0.1F, "expected an angle in [0, pi/2]");
    with("sigma", 3, 0, "0; expected a positive number");
    with("ndf", 3, -1, "-1; expected a finite number, 0 or more");
    with("vndf", 3, -1, "-1; expected a finite number, 0 or more");
    std::vector<TensorField> fields = rgl_fields();
    std::fill_n(field_of(fields, "vndf").values.begin() + 54, 54, 0.0F);
    refused(fields, "expected a positive value in each slice");
    for (const char* name : {"vndf", "luminance", "rgb"}) {
        fields = rgl_fields();
        field_of(fields, name).shape[1] = 3;
        refused(fields, "as the others say");
    }
    fields = rgl_fields();
    field_of(fields, "ndf").shape = {21, 1};
    refused(fields, "21 x 1 nodes; expected 2 to 4096");
    field_of(fields, "ndf").shape = {2, 5000};
    field_of(fields, "ndf").values.assign(10000, 1);
    refused(fields, "2 x 5000 nodes; expected 2 to 4096");
}

TEST_F(Rgl, mutated_files_are_read_or_refused) {
    test::Mutations mutations(test::tensor_bytes(rgl_fields()));
    int refused = 0;
    for (int i = 0; i < 1000; ++i) {
        write_file(path, mutations.next());
        Samples samples;
        const std::string message = complaint([&] { samples = read_samples(path); });
        if (message.empty())
            test::expect_whole(samples, "a mutation");
        else
            EXPECT_EQ(message.find(path + ": "), 0U) << message;
        refused += !message.empty();
    }
    EXPECT_GT(refused, 300);
    EXPECT_LT(refused, 1000);
}

} // namespace

} // namespace brdfit
