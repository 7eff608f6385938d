#include "host/error.hpp"
#include "host/files/directions.hpp"
#include "host/measured/merl.hpp"
#include "host/measured/read.hpp"
#include "host/measured/write.hpp"
#include "tests/support/support.hpp"

#include <cmath>
#include <cstring>
#include <fstream>
#include <gtest/gtest.h>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <sys/stat.h>
#include <unistd.h>

namespace brdfit {

namespace {

using test::run_program;
using test::TemporaryFolder;
using test::write_file;

constexpr std::size_t merl_size = 12 + 3 * merl::bins * sizeof(double);

const std::string csv_head = "theta_i,phi_i,theta_o,phi_o,R,G\n";
const std::string csv_example = csv_head + "0.5,0,0.25,3,0.1,0.2\n0.5,0,0.75,-1.5,-0.01,2e-2\n";
const std::string astm_example = "LAB_NAME A laboratory\nNUM_POINTS 2\n"
                                 "VARS theta_i,phi_i,theta_s,phi_s,R,G\n\n"
                                 "0.872665,0.0,0.573513,0.1,0.011364,-0.000779\n"
                                 "0.698132,0.0,0.427512,-0.2,0.012770,0.000718\n";
const std::string cornell_example = "# num wls\n3\n\n# wls\n400 450\n500\n\n# theta i, ...\n\n"
                                    "0.5 0.0 0.25 0.0 0.1 0.2 0.3\n0.6 0.0 0.35 1.0 0.5 0.6 0.7\n";
const std::string npy_example = [] {
    const std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 6), }\n";
    const float rows[12] = {0, 0, 1, 0.6F, 0, 0.8F, 0, 0, 1, 0, 1, 0};
    std::string bytes("\x93NUMPY\x01\x00", 8);
    bytes += {static_cast<char>(header.size()), '\0'};
    return bytes + header + std::string(reinterpret_cast<const char*>(rows), sizeof rows);
}();

std::string merl_header(std::int32_t a, std::int32_t b, std::int32_t c) {
    const std::int32_t dimensions[] = {a, b, c};
    return {reinterpret_cast<const char*>(dimensions), sizeof dimensions};
}

/// The example with the first `from` replaced by `to`.
std::string changed(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

/// What reading says: the message of its InputError, or "read" when there is none.
template <typename Read>
std::string complaint(const Read& read) {
    try {
        read();
    } catch (const InputError& error) {
        return error.what();
    }
    return "read";
}

class BadMeasured : public testing::Test {
  protected:
    const TemporaryFolder folder;
    const std::string path = folder / "bad file";

    /// What read_samples says of a file with these bytes.
    std::string complaint_of(const std::string& bytes) {
        write_file(path, bytes);
        return complaint([&] { read_samples(path); });
    }
    std::string directions_complaint(const std::string& bytes) {
        write_file(path, bytes);
        return complaint([&] { read_directions(path); });
    }
    /// A sparse MERL file: all zeros but for its header.
    void make_merl() {
        write_file(path, merl_header(90, 90, 180));
        std::filesystem::resize_file(path, merl_size);
    }
    /// Changes a stored value.
    void store(std::size_t channel, std::size_t bin, double value) {
        std::fstream file(path, std::ios::in | std::ios::out | std::ios::binary);
        file.seekp(static_cast<std::streamoff>(12 + (channel * merl::bins + bin) * sizeof value));
        file.write(reinterpret_cast<const char*>(&value), sizeof value);
    }
};

#define EXPECT_COMPLAINT(message, part)                                                            \
    do {                                                                                           \
        const std::string text = message;                                                          \
        EXPECT_NE(text.find(part), std::string::npos) << text;                                     \
        EXPECT_EQ(text.find(path + ": "), 0U) << text;                                             \
    } while (false)

TEST_F(BadMeasured, NotAFileWithData) {
    EXPECT_COMPLAINT(complaint([&] { read_samples(path); }), "cannot open");
    EXPECT_COMPLAINT(complaint_of(""), "empty");
    EXPECT_NE(complaint([&] { read_samples(folder.path()); }).find("is a directory"),
              std::string::npos);
    const std::string fifo = folder / "fifo";
    ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
    EXPECT_NE(complaint([&] { read_samples(fifo); }).find("not a regular file"), std::string::npos);
    EXPECT_NE(complaint([&] { read_samples("/dev/zero"); }), "read");
    EXPECT_NE(complaint([&] { read_samples("/proc/self/mem"); }), "read");
    EXPECT_NE(complaint([&] { read_directions(folder / "missing"); }), "read");
}

TEST_F(BadMeasured, Unreadable) {
    if (geteuid() == 0)
        GTEST_SKIP() << "root reads everything";
    write_file(path, csv_example);
    std::filesystem::permissions(path, std::filesystem::perms::none);
    EXPECT_COMPLAINT(complaint([&] { read_samples(path); }), "cannot open");
}

TEST_F(BadMeasured, UnknownContentListsTheFormats) {
    for (const std::string& bytes :
         {std::string("x"), std::string("\n\n\n"), std::string("# only a comment\n"),
          std::string("a,b,c\n1,2,3\n"), std::string(100000, '\0'), std::string(1000, '\xff'),
          npy_example, std::string("\x89PNG\r\n\x1a\n and more")}) {
        EXPECT_COMPLAINT(complaint_of(bytes), "unknown format; known: MERL .binary, ASTM");
        EXPECT_COMPLAINT(complaint_of(bytes), "theta_i,phi_i,theta_o,phi_o");
    }
}

TEST_F(BadMeasured, MerlHeader) {
    const std::string data(1000, '\0');
    EXPECT_COMPLAINT(complaint_of(merl_header(90, 90, 181) + data),
                     "header: dimensions are 90x90x181; expected 90x90x180");
    EXPECT_COMPLAINT(complaint_of(merl_header(-90, 90, 180) + data), "dimensions are -90x90x180");
    EXPECT_COMPLAINT(complaint_of(merl_header(90, 2147483647, 2147483647) + data),
                     "dimensions are 90x2147483647x2147483647");
    EXPECT_COMPLAINT(complaint_of(merl_header(10, 20, 30) + data), "dimensions are 10x20x30");
    EXPECT_COMPLAINT(complaint_of(merl_header(90, 0, 0) + data), "dimensions are 90x0x0");
    // The size tells what a file with a broken header is.
    write_file(path, merl_header(-1, -1, -1));
    std::filesystem::resize_file(path, merl_size);
    EXPECT_COMPLAINT(complaint([&] { read_samples(path); }), "dimensions are -1x-1x-1");
}

TEST_F(BadMeasured, MerlCutOrTooLong) {
    const std::string header = merl_header(90, 90, 180);
    for (std::size_t size : {4U, 5U, 8U, 11U})
        EXPECT_COMPLAINT(complaint_of(header.substr(0, size)), "header: the file ends after");
    make_merl();
    for (std::size_t size :
         {merl_size - 1, merl_size - 8, merl_size / 2, merl_size / 3, std::size_t{4096},
          std::size_t{20}, std::size_t{13}, std::size_t{12}}) {
        std::filesystem::resize_file(path, size);
        EXPECT_COMPLAINT(complaint([&] { read_samples(path); }), "the file ends after " +
                                                                     std::to_string(size) +
                                                                     " bytes; expected 34992012");
    }
    std::filesystem::resize_file(path, merl_size + 1);
    EXPECT_COMPLAINT(complaint([&] { read_samples(path); }), "the file has 34992013 bytes");
}

TEST_F(BadMeasured, MerlNotFinite) {
    const std::size_t bin = (12 * 90 + 34) * 180 + 56;
    const double infinity = std::numeric_limits<double>::infinity();
    for (const double value : {std::nan(""), infinity, -infinity, 1e300}) {
        make_merl();
        store(1, bin, value);
        EXPECT_COMPLAINT(complaint([&] { read_samples(path); }),
                         "channel G, bin (theta_h 12, theta_d 34, phi_d 56)");
    }
    make_merl();
    store(0, 0, std::nan(""));
    EXPECT_COMPLAINT(
        complaint([&] { read_samples(path); }),
        "channel R, bin (theta_h 0, theta_d 0, phi_d 0): nan; expected a finite number");
    make_merl();
    store(2, merl::bins - 1, infinity);
    EXPECT_COMPLAINT(complaint([&] { read_samples(path); }),
                     "channel B, bin (theta_h 89, theta_d 89, phi_d 179): inf");
}

TEST_F(BadMeasured, MerlWithoutAValidSampleIsRead) {
    const std::vector<double> values(3 * merl::bins, -1);
    write_file(path,
               merl_header(90, 90, 180) + std::string(reinterpret_cast<const char*>(values.data()),
                                                      values.size() * sizeof(double)));
    const Samples samples = read_samples(path);
    EXPECT_EQ(samples.valid_count(), 0U);
    const test::Outcome text = run_program({"info", path});
    EXPECT_EQ(text.status, 0) << text.err;
    EXPECT_NE(text.out.find("  valid          0\n"), std::string::npos) << text.out;
    const test::Outcome json = run_program({"info", "--json", path});
    EXPECT_EQ(nlohmann::json::parse(json.out)["valid"], 0);
    EXPECT_TRUE(nlohmann::json::parse(json.out)["range"].is_null());
    for (const char* name : {"out.csv", "out.npy"}) {
        const std::string out = folder / name;
        EXPECT_NE(complaint([&] { write_samples(samples, out); }).find("no valid samples"),
                  std::string::npos);
        EXPECT_FALSE(std::filesystem::exists(out));
    }
}

TEST_F(BadMeasured, MerlCannotBeAnisotropic) {
    make_merl();
    EXPECT_THROW(read_samples(path, false), UsageError);
    EXPECT_EQ(run_program({"info", "--anisotropic", path}).status, 2);
    EXPECT_EQ(read_samples(path, true).count(), merl::bins);
}

TEST_F(BadMeasured, CsvHeader) {
    const std::string row = "0.5,0,0.25,3,0.1,0.2\n";
    const auto with_header = [&](const std::string& header) { return complaint_of(header + row); };
    EXPECT_COMPLAINT(with_header("theta_i,phi_i,theta_o,R,G,B\n"),
                     "line 1: column 'phi_o' is missing");
    EXPECT_COMPLAINT(with_header("# a\n\ntheta_i,phi_i,phi_o,R,G,B\n"),
                     "line 3: column 'theta_o' is missing");
    EXPECT_COMPLAINT(with_header("theta_i\n"), "line 1: column 'phi_i' is missing");
    EXPECT_COMPLAINT(complaint_of("theta_i,phi_i,theta_o,phi_o\n0.5,0,0.25,3\n"),
                     "line 1: no column holds values");
    EXPECT_COMPLAINT(complaint_of("theta_i,phi_i,theta_o,phi_o,weight\n0.5,0,0.25,3,1\n"),
                     "line 1: no column holds values");
    EXPECT_COMPLAINT(with_header("theta_i,phi_i,theta_o,phi_o,R,R\n"), "two columns are named 'R'");
    EXPECT_COMPLAINT(with_header("theta_i,phi_i,theta_o,phi_o,R,\n"), "a column has no name");
}

TEST_F(BadMeasured, CsvRows) {
    const auto with_row = [&](const std::string& row) {
        return complaint_of(csv_head + "0.5,0,0.25,3,0.1,0.2\n" + row);
    };
    EXPECT_COMPLAINT(complaint_of(csv_head), "no samples");
    EXPECT_COMPLAINT(complaint_of("# note\n" + csv_head + "\n\n"), "no samples");
    EXPECT_COMPLAINT(with_row("0.5,0,0.25,3,0.1"), "line 3: 5 fields; expected 6");
    EXPECT_COMPLAINT(with_row("0.5,0,0.25,3,0.1,0.2,0.3\n"), "line 3: 7 fields; expected 6");
    EXPECT_COMPLAINT(with_row("0.5,0,0.25,3,red,0.2"),
                     "line 3: column R: 'red'; expected a finite number");
    for (const char* number : {"", " ", "0x1", "1,5", "1.5.2", "1e", "--1", "+-1", "+", "nan",
                               "inf", "-inf", "NaN", "1e999", "1e39", "0.1 0.2", "1;2", "\"1\""})
        EXPECT_NE(with_row(std::string("0.5,0,0.25,3,0.1,") + number), "read") << number;
    EXPECT_COMPLAINT(with_row("0.5,nan,0.25,3,0.1,0.2"), "column phi_i: 'nan'");
    EXPECT_COMPLAINT(with_row("0.5,0,0.25,3,0.1,1e39"), "column G: '1e39' is too large");
    EXPECT_COMPLAINT(with_row("0.5,0,0.25,3," + std::string(1000, '7') + "x,0.2"),
                     "'7777777777777777777777777777777777777777...'");
}

TEST_F(BadMeasured, BelowTheHorizon) {
    EXPECT_COMPLAINT(complaint_of(csv_head + "0.5,0,0.25,3,0.1,0.2\n\n1.6,0,0.25,3,0.1,0.2\n"),
                     "line 4: column theta_i: '1.6'; expected an angle in [0, pi/2] radians");
    EXPECT_COMPLAINT(complaint_of(csv_head + "0.5,0,45,3,0.1,0.2\n"),
                     "line 2: column theta_o: '45'");
    EXPECT_COMPLAINT(complaint_of(csv_head + "-0.1,0,1,3,0.1,0.2\n"), "column theta_i: '-0.1'");
    EXPECT_COMPLAINT(complaint_of(changed(astm_example, "0.573513", "1.573513")),
                     "line 5: column theta_s: '1.573513'");
    EXPECT_COMPLAINT(complaint_of(changed(cornell_example, "0.6", "2")),
                     "line 11: column theta_i: '2'");
}

TEST_F(BadMeasured, NegativeWeight) {
    EXPECT_COMPLAINT(complaint_of("theta_i,phi_i,theta_o,phi_o,R,weight\n0.5,0,1,3,0.1,-1\n"),
                     "line 2: column weight: '-1'; expected 0 or more");
}

TEST_F(BadMeasured, Astm) {
    EXPECT_COMPLAINT(complaint_of(changed(astm_example, "NUM_POINTS 2", "NUM_POINTS 3")),
                     "2 rows; expected 3 as NUM_POINTS says");
    EXPECT_COMPLAINT(complaint_of(changed(astm_example, "S 2", "S 99999999999999999")), "expected");
    EXPECT_COMPLAINT(complaint_of(changed(astm_example, "S 2", "S 99999999999999999999999")),
                     "line 2: NUM_POINTS: '99999999999999999999999'; expected a whole number");
    EXPECT_COMPLAINT(complaint_of(changed(astm_example, "S 2", "S -2")),
                     "line 2: NUM_POINTS: '-2'");
    EXPECT_COMPLAINT(complaint_of(changed(astm_example, "S 2", "S")), "line 2: NUM_POINTS: ''");
    EXPECT_COMPLAINT(complaint_of(changed(astm_example, "VARS", "VARIABLES")), "no line VARS");
    EXPECT_COMPLAINT(complaint_of(changed(astm_example, "phi_s", "phi")),
                     "line 3: column 'phi_s' is missing");
    EXPECT_COMPLAINT(complaint_of(changed(astm_example, "0.011364", "bright")),
                     "line 5: column R: 'bright'");
    EXPECT_COMPLAINT(complaint_of(changed(astm_example, ",0.011364", "")),
                     "line 5: 5 fields; expected 6");
    EXPECT_COMPLAINT(complaint_of("NUM_POINTS 0\nVARS theta_i,phi_i,theta_s,phi_s,R\n"),
                     "no samples");
}

TEST_F(BadMeasured, Cornell) {
    EXPECT_COMPLAINT(complaint_of("# num wls\n"), "unknown format");
    EXPECT_COMPLAINT(complaint_of(changed(cornell_example, "\n3\n", "\n0\n")), "no wavelengths");
    EXPECT_COMPLAINT(complaint_of(changed(cornell_example, "\n3\n", "\n-3\n")),
                     "line 2: number of wavelengths: '-3'");
    EXPECT_COMPLAINT(complaint_of(changed(cornell_example, "\n3\n", "\n2\n")),
                     "line 6: 1 fields; expected 6");
    EXPECT_COMPLAINT(complaint_of(changed(cornell_example, "\n3\n", "\n1\n")),
                     "line 5: 2 wavelengths; expected 1");
    EXPECT_COMPLAINT(complaint_of(changed(cornell_example, "\n3\n", "\n4\n")),
                     "line 10: wavelength '0.0'; expected a positive number");
    EXPECT_COMPLAINT(complaint_of(changed(cornell_example, "\n3\n", "\n99999999999999\n")),
                     "expected");
    EXPECT_COMPLAINT(complaint_of(changed(cornell_example, "450", "blue")), "line 5: ");
    EXPECT_COMPLAINT(complaint_of(changed(cornell_example, "450", "-450")), "a positive number");
    EXPECT_COMPLAINT(complaint_of(changed(cornell_example, "450", "400")), "two columns");
    EXPECT_COMPLAINT(complaint_of(changed(cornell_example, " 0.7", "")),
                     "line 11: 6 fields; expected 7");
    EXPECT_COMPLAINT(complaint_of(changed(cornell_example, " 0.7", " nan")),
                     "line 11: column 500: 'nan'");
    EXPECT_COMPLAINT(complaint_of(cornell_example.substr(0, cornell_example.find("0.5"))),
                     "no samples");
}

TEST_F(BadMeasured, DirectionsCsv) {
    const std::string head = "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n";
    EXPECT_COMPLAINT(directions_complaint("x,y\n1,2\n"), "unknown format; expected CSV");
    EXPECT_COMPLAINT(directions_complaint(head), "no directions");
    EXPECT_COMPLAINT(directions_complaint("wi_x,wi_y,wi_z,wo_x,wo_y\n"), "'wo_z' is missing");
    EXPECT_COMPLAINT(directions_complaint("wi_x,wi_y,wi_z,wo_x,wo_y,wo_z,R\n"),
                     "line 1: 7 columns");
    EXPECT_COMPLAINT(directions_complaint(head + "0,0,1,0,0\n"), "line 2: 5 fields; expected 6");
    EXPECT_COMPLAINT(directions_complaint(head + "0,0,1,0,0,1\n0,0,1,0,0,1.1\n"),
                     "line 3: wo is not a unit vector");
    EXPECT_COMPLAINT(directions_complaint(head + "0,0,0,0,0,1\n"),
                     "line 2: wi is not a unit vector");
    EXPECT_COMPLAINT(directions_complaint(head + "0,up,1,0,0,1\n"), "line 2: column wi_y: 'up'");
}

TEST_F(BadMeasured, DirectionsNpy) {
    EXPECT_EQ(directions_complaint(npy_example), "read");
    const auto with = [&](const std::string& from, const std::string& to) {
        std::string bytes = changed(npy_example, from, to);
        bytes[8] = static_cast<char>(bytes[8] + static_cast<int>(to.size() - from.size()));
        return directions_complaint(bytes);
    };
    EXPECT_COMPLAINT(with("<f4", "<i4"), "expected the type");
    EXPECT_COMPLAINT(with("<f4", ">f4"), "expected the type");
    EXPECT_COMPLAINT(with("<f4", "<f8"), "48 bytes of data; expected 2 x 6 values of 8 bytes");
    EXPECT_COMPLAINT(with("False", "True"), "C order");
    EXPECT_COMPLAINT(with("False", "0"), "True or False");
    EXPECT_COMPLAINT(with("(2, 6)", "(3, 6)"), "48 bytes of data; expected 3 x 6");
    EXPECT_COMPLAINT(with("(2, 6)", "(1, 6)"), "48 bytes of data; expected 1 x 6");
    EXPECT_COMPLAINT(with("(2, 6)", "(3, 4)"), "3 rows of 4 columns");
    EXPECT_COMPLAINT(with("(2, 6)", "(12,)"), "1 dimensions; expected 2");
    EXPECT_COMPLAINT(with("(2, 6)", "()"), "0 dimensions; expected 2");
    EXPECT_COMPLAINT(with("(2, 6)", "(2, -6)"), "whole number");
    EXPECT_COMPLAINT(with("(2, 6)", "(0, 6)"), "expected 0 x 6");
    EXPECT_COMPLAINT(with("(2, 6)", "(12297829382473034411, 6)"), "48 bytes of data");
    EXPECT_COMPLAINT(with("(2, 6)", "(4611686018427387906, 6)"), "48 bytes of data");
    EXPECT_COMPLAINT(with("(2, 6)", "(99999999999999999999999, 6)"), "whole number");
    EXPECT_COMPLAINT(with("'descr'", "'type'"), "unknown key");
    EXPECT_COMPLAINT(with("'shape': (2, 6), ", ""), "expected descr, fortran_order and shape");
    std::string bytes = npy_example;
    bytes[6] = 4;
    EXPECT_COMPLAINT(directions_complaint(bytes), "version 4");
    bytes[6] = 2; // the length is now four bytes, of which two are text
    EXPECT_COMPLAINT(directions_complaint(bytes), "the file ends inside it");
    for (std::size_t size = 6; size < npy_example.size(); ++size)
        EXPECT_NE(directions_complaint(npy_example.substr(0, size)), "read") << size;
    const float not_a_number = std::nanf("");
    bytes = npy_example;
    std::memcpy(bytes.data() + bytes.size() - 4, &not_a_number, 4);
    EXPECT_COMPLAINT(directions_complaint(bytes), "row 1: wo is not a unit vector");
}

TEST_F(BadMeasured, ChannelNamesThatNoCsvCanHold) {
    write_file(path, csv_example);
    for (const char* name : {"", "a,b", "a\nb", " a", "phi_i", "weight", "G"}) {
        Samples samples = read_samples(path);
        samples.channels[0] = name;
        const std::string out = folder / "out.csv";
        EXPECT_NE(complaint([&] { write_samples(samples, out); }), "read") << name;
        EXPECT_FALSE(std::filesystem::exists(out));
    }
}

TEST_F(BadMeasured, OutputThatCannotBeWritten) {
    write_file(path, "theta_i,phi_i,theta_o,phi_o,R,G,B\n0.5,0,0.25,3,1,2,3\n");
    const Samples samples = read_samples(path);
    for (const std::string ending : {".csv", ".npy", ".binary"}) {
        const std::string below_a_file = path + "/out" + ending;
        EXPECT_NE(complaint([&] { write_samples(samples, below_a_file); }).find("cannot write"),
                  std::string::npos);
        EXPECT_NE(complaint([&] { write_samples(samples, folder / "no/out" + ending); }), "read");
        const std::string full = folder / "full" + ending;
        std::filesystem::create_symlink("/dev/full", full);
        EXPECT_NE(complaint([&] { write_samples(samples, full); }).find("No space left"),
                  std::string::npos);
        EXPECT_EQ(run_program({"convert", path, full}).status, 1);
        const std::string directory = folder / "directory" + ending;
        std::filesystem::create_directory(directory);
        EXPECT_NE(complaint([&] { write_samples(samples, directory); }).find("is a directory"),
                  std::string::npos);
        std::filesystem::remove(full);
        std::filesystem::remove(directory);
    }
    EXPECT_THROW(write_samples(samples, folder / "out.txt"), UsageError);
    // Nothing stays behind.
    for (const auto& entry : std::filesystem::directory_iterator(folder.path()))
        EXPECT_EQ(entry.path(), path);
}

TEST_F(BadMeasured, ExitStatus) {
    write_file(path, csv_example);
    const auto status = [](const std::vector<std::string>& arguments) {
        const test::Outcome outcome = run_program(arguments);
        EXPECT_EQ(outcome.err.empty(), outcome.status == 0) << outcome.err;
        return outcome.status;
    };
    const std::string out = folder / "out.csv";
    EXPECT_EQ(status({"info", path}), 0);
    EXPECT_EQ(status({"info", folder / "missing"}), 1);
    EXPECT_EQ(status({"info"}), 2);
    EXPECT_EQ(status({"info", "--isotropic", "--anisotropic", path}), 2);
    EXPECT_EQ(status({"info", "--unknown", path}), 2);
    EXPECT_EQ(status({"convert", path, out}), 0);
    EXPECT_EQ(status({"convert", path}), 2);
    EXPECT_EQ(status({"convert", path, folder / "out.txt"}), 2);
    EXPECT_EQ(status({"convert", folder / "missing", out}), 1);
    EXPECT_EQ(status({"convert", path, folder / "out.binary"}), 1) << "two channels";
}

TEST_F(BadMeasured, EveryCutIsReadOrRefused) {
    for (const std::string& example : {csv_example, astm_example, cornell_example})
        for (std::size_t size = 1; size < example.size(); ++size)
            complaint_of(example.substr(0, size));
}

TEST_F(BadMeasured, MutatedFilesAreReadOrRefused) {
    std::mt19937 random(20240229);
    const auto below = [&](std::size_t n) { return random() % n; };
    const std::string alphabet("0123456789.,-+eE# \r\n\t\0\xff"
                               "naif",
                               27);
    int refused = 0;
    for (const std::string& example : {csv_example, astm_example, cornell_example, npy_example,
                                       merl_header(90, 90, 180) + std::string(200, '\0')})
        for (int i = 0; i < 1000; ++i) {
            std::string bytes = example;
            for (std::size_t n = 1 + below(4); n > 0 && !bytes.empty(); --n) {
                const std::size_t at = below(bytes.size());
                switch (below(5)) {
                case 0:
                    bytes[at] = static_cast<char>(random());
                    break;
                case 1:
                    bytes[at] = alphabet[below(alphabet.size())];
                    break;
                case 2:
                    bytes.erase(at, 1 + below(8));
                    break;
                case 3:
                    bytes.insert(at, 1 + below(4), alphabet[below(alphabet.size())]);
                    break;
                default:
                    bytes.insert(at, bytes.substr(below(bytes.size()), 1 + below(60)));
                }
            }
            // Anything but an InputError leaves the test.
            const std::string samples = complaint_of(bytes);
            refused += samples != "read";
            if (samples == "read") {
                const Samples read = read_samples(path);
                for (const float x : read.values)
                    ASSERT_TRUE(std::isfinite(x)) << bytes;
                for (const float x : read.directions->data())
                    ASSERT_TRUE(std::isfinite(x)) << bytes;
            }
            if (directions_complaint(bytes) == "read") {
                const Directions read = read_directions(path);
                for (const float x : read.data())
                    ASSERT_TRUE(std::isfinite(x)) << bytes;
            }
        }
    EXPECT_GT(refused, 2000);
    EXPECT_LT(refused, 5000);
}

} // namespace

} // namespace brdfit
