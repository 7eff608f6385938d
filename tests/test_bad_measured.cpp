// What a broken measured file says, and what is left where one cannot be written.

#include "host/error.hpp"
#include "host/files/channels.hpp"
#include "host/files/directions.hpp"
#include "host/files/file.hpp"
#include "host/files/npy.hpp"
#include "host/measured/merl.hpp"
#include "host/measured/read.hpp"
#include "host/measured/write.hpp"
#include "tests/support/bad_files.hpp"
#include "tests/support/measured.hpp"
#include "tests/support/support.hpp"

#include <cmath>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <fmt/format.h>
#include <fstream>
#include <gtest/gtest.h>
#include <limits>
#include <nlohmann/json.hpp>
#include <sys/resource.h>
#include <sys/stat.h>
#include <unistd.h>

namespace brdfit {

namespace {

using test::astm_example;
using test::changed;
using test::complaint;
using test::cornell_example;
using test::csv_example;
using test::csv_head;
using test::expect_whole;
using test::merl_header;
using test::Mutations;
using test::run_program;
using test::TemporaryFolder;
using test::write_file;

constexpr std::size_t merl_size = 12 + 3 * merl::bins * sizeof(double);

class BadMeasured : public testing::Test {
  protected:
    const TemporaryFolder folder;
    const std::string path = folder / "bad file";

    /// What read_samples says of a file with these bytes; empty where it reads them.
    std::string complaint_of(const std::string& bytes) {
        write_file(path, bytes);
        return complaint([&] { read_samples(path); });
    }
    /// The samples of a file with these bytes are whole, or the InputError names the file. Returns
    /// how many were read.
    std::size_t read_or_refused(const std::string& bytes) {
        write_file(path, bytes);
        Samples samples;
        const std::string message = complaint([&] { samples = read_samples(path); });
        if (message.empty())
            expect_whole(samples, bytes);
        else
            EXPECT_EQ(message.find(path + ": "), 0U) << message;
        return samples.count();
    }
    void expects(const std::string& message, const std::string& part) {
        test::expect_complaint(message, path, part);
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

TEST_F(BadMeasured, what_is_no_file_with_data_is_refused) {
    expects(complaint([&] { read_samples(path); }), "cannot open");
    expects(complaint_of(""), "empty");
    EXPECT_NE(complaint([&] { read_samples(folder.path()); }).find("is a directory"),
              std::string::npos);
    const std::string fifo = folder / "fifo";
    ASSERT_EQ(mkfifo(fifo.c_str(), 0600), 0);
    EXPECT_NE(complaint([&] { read_samples(fifo); }).find("not a regular file"), std::string::npos);
    EXPECT_NE(complaint([&] { read_samples("/dev/zero"); }), "");
    EXPECT_NE(complaint([&] { read_samples("/proc/self/mem"); }), "");
    EXPECT_NE(complaint([&] { read_directions(folder / "missing"); }), "");
}

TEST_F(BadMeasured, an_unreadable_file_is_refused) {
    if (geteuid() == 0)
        GTEST_SKIP() << "root reads everything";
    write_file(path, csv_example);
    std::filesystem::permissions(path, std::filesystem::perms::none);
    expects(complaint([&] { read_samples(path); }), "cannot open");
}

TEST_F(BadMeasured, unknown_content_lists_the_formats) {
    for (const std::string& bytes :
         {std::string("x"), std::string("\n\n\n"), std::string("# only a comment\n"),
          std::string("a,b,c\n1,2,3\n"), std::string(100000, '\0'), std::string(1000, '\xff'),
          std::string("\x89PNG\r\n\x1a\n and more")}) {
        expects(complaint_of(bytes), "unknown format; known: MERL .binary, RGL .bsdf, UTIA .bin");
        expects(complaint_of(bytes), "theta_i,phi_i,theta_o,phi_o");
    }
}

// Pages of a file that are touched show as faults; 20 GB are 300,000 at least.
TEST_F(BadMeasured, a_huge_file_is_refused_without_reading_it) {
    const auto faults = [] {
        rusage usage{};
        getrusage(RUSAGE_SELF, &usage);
        return usage.ru_minflt + usage.ru_majflt;
    };
    for (const auto& [head, says] : std::vector<std::pair<std::string, std::string>>{
             {std::string(1, '\0'), "unknown format"},
             {merl_header(90, 90, 180), "the file has 20000000000 bytes"},
             {csv_example, "line 4: longer than"},
             {astm_example, "line 7: longer than"},
             {cornell_example, "line 12: longer than"},
             {csv_head + "red,0,0.25,3,0.1,0.2\n", "line 2: column theta_i"}}) {
        write_file(path, head);
        std::filesystem::resize_file(path, 20'000'000'000);
        const long before = faults();
        expects(complaint([&] { read_samples(path); }), says);
        EXPECT_LT(faults() - before, 30000) << says;
    }
    EXPECT_NE(complaint([&] { read_directions(path); }), "");
}

extern "C" void replace_page(int, siginfo_t* info, void*) {
    if (!replace_cut_page(info->si_addr))
        std::abort();
}

// Touching what is no longer there ends the process where nothing is put in its place.
TEST_F(BadMeasured, a_file_that_becomes_shorter_is_an_error) {
    struct sigaction action {
    }, before{};
    action.sa_sigaction = replace_page;
    action.sa_flags = SA_SIGINFO;
    sigaction(SIGBUS, &action, &before);
    make_merl();
    const MappedFile file(path);
    EXPECT_NO_THROW(file.require_whole());
    for (const std::size_t size : {merl_size - 1, std::size_t{5000}, std::size_t{0}}) {
        std::filesystem::resize_file(path, size);
        for (std::size_t at = 0; at < merl_size; at += 1000003)
            EXPECT_TRUE(file.bytes()[at] == 0 || at < 12);
        expects(complaint([&] { file.require_whole(); }), "became shorter than 34992012 bytes");
    }
    sigaction(SIGBUS, &before, nullptr);
}

TEST_F(BadMeasured, merl_header_must_have_its_dimensions) {
    const std::string data(1000, '\0');
    expects(complaint_of(merl_header(90, 90, 181) + data),
            "header: dimensions are 90x90x181; expected 90x90x180");
    expects(complaint_of(merl_header(-90, 90, 180) + data), "dimensions are -90x90x180");
    expects(complaint_of(merl_header(90, 2147483647, 2147483647) + data),
            "dimensions are 90x2147483647x2147483647");
    expects(complaint_of(merl_header(10, 20, 30) + data), "dimensions are 10x20x30");
    expects(complaint_of(merl_header(90, 0, 0) + data), "dimensions are 90x0x0");
    // The size tells what a file with a broken header is.
    write_file(path, merl_header(-1, -1, -1));
    std::filesystem::resize_file(path, merl_size);
    expects(complaint([&] { read_samples(path); }), "dimensions are -1x-1x-1");
}

TEST_F(BadMeasured, merl_cut_or_too_long_is_refused) {
    const std::string header = merl_header(90, 90, 180);
    for (std::size_t size : {4U, 5U, 8U, 11U})
        expects(complaint_of(header.substr(0, size)), "header: the file ends after");
    make_merl();
    for (std::size_t size :
         {merl_size - 1, merl_size - 8, merl_size / 2, merl_size / 3, std::size_t{4096},
          std::size_t{20}, std::size_t{13}, std::size_t{12}}) {
        std::filesystem::resize_file(path, size);
        expects(complaint([&] { read_samples(path); }),
                "the file ends after " + std::to_string(size) + " bytes; expected 34992012");
    }
    std::filesystem::resize_file(path, merl_size + 1);
    expects(complaint([&] { read_samples(path); }), "the file has 34992013 bytes");
}

TEST_F(BadMeasured, merl_value_that_is_not_finite_is_named_by_bin) {
    const std::size_t bin = (12 * 90 + 34) * 180 + 56;
    const double infinity = std::numeric_limits<double>::infinity();
    for (const double value : {std::nan(""), infinity, -infinity, 1e300}) {
        make_merl();
        store(1, bin, value);
        expects(complaint([&] { read_samples(path); }),
                "channel G, bin (theta_h 12, theta_d 34, phi_d 56)");
    }
    make_merl();
    store(0, 0, std::nan(""));
    expects(complaint([&] { read_samples(path); }),
            "channel R, bin (theta_h 0, theta_d 0, phi_d 0): nan; expected a finite number");
    make_merl();
    store(2, merl::bins - 1, infinity);
    expects(complaint([&] { read_samples(path); }),
            "channel B, bin (theta_h 89, theta_d 89, phi_d 179): inf");
}

TEST_F(BadMeasured, merl_without_a_valid_sample_is_read) {
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

TEST_F(BadMeasured, merl_cannot_be_anisotropic) {
    make_merl();
    EXPECT_THROW(read_samples(path, false), UsageError);
    EXPECT_EQ(run_program({"info", "--anisotropic", path}).status, 2);
    EXPECT_EQ(read_samples(path, true).count(), merl::bins);
}

TEST_F(BadMeasured, csv_header_must_have_its_columns) {
    const std::string row = "0.5,0,0.25,3,0.1,0.2\n";
    const auto with_header = [&](const std::string& header) { return complaint_of(header + row); };
    expects(with_header("theta_i,phi_i,theta_o,R,G,B\n"), "line 1: column 'phi_o' is missing");
    expects(with_header("# a\n\ntheta_i,phi_i,phi_o,R,G,B\n"),
            "line 3: column 'theta_o' is missing");
    expects(with_header("theta_i\n"), "line 1: column 'phi_i' is missing");
    expects(complaint_of("theta_i,phi_i,theta_o,phi_o\n0.5,0,0.25,3\n"),
            "line 1: no column holds values");
    expects(complaint_of("theta_i,phi_i,theta_o,phi_o,weight\n0.5,0,0.25,3,1\n"),
            "line 1: no column holds values");
    expects(with_header("theta_i,phi_i,theta_o,phi_o,R,R\n"), "two columns are named 'R'");
    expects(with_header("theta_i,phi_i,theta_o,phi_o,R,\n"), "a column has no name");
}

TEST_F(BadMeasured, channels_are_named_and_counted_as_materials_take_them) {
    const std::string row = "0.5,0,0.25,3,0.1,0.2\n";
    for (const char* name : {"\"R\"", "R\xff", "R\x01", "\xc3"})
        expects(complaint_of(std::string("theta_i,phi_i,theta_o,phi_o,G,") + name + "\n" + row),
                "line 1: column 6: ");
    EXPECT_EQ(complaint_of("theta_i,phi_i,theta_o,phi_o,G,\xc3\xa9t\xc3\xa9 #1\n" + row), "");
    expects(complaint_of(changed(astm_example, "phi_s,R", "phi_s,\"R\"")), "line 3: column 5: ");
    std::string header = "theta_i,phi_i,theta_o,phi_o", values = "0.5,0,0.25,3";
    for (std::size_t ch = 0; ch <= max_channels; ++ch) {
        header += fmt::format(",c{}", ch);
        values += ",0.1";
    }
    expects(complaint_of(header + '\n' + values + '\n'),
            "line 1: 4097 channels; expected at most 4096");
    expects(complaint_of(npy::header(1, 6 + max_channels + 2) +
                         std::string((6 + max_channels + 2) * sizeof(float), '\0')),
            "4097 channels; expected at most 4096");
}

TEST_F(BadMeasured, csv_row_is_named_by_line_and_column) {
    const auto with_row = [&](const std::string& row) {
        return complaint_of(csv_head + "0.5,0,0.25,3,0.1,0.2\n" + row);
    };
    expects(complaint_of(csv_head), "no samples");
    expects(complaint_of("# note\n" + csv_head + "\n\n"), "no samples");
    expects(with_row("0.5,0,0.25,3,0.1"), "line 3: 5 fields; expected 6");
    expects(with_row("0.5,0,0.25,3,0.1,0.2,0.3\n"), "line 3: 7 fields; expected 6");
    expects(with_row("0.5,0,0.25,3,red,0.2"), "line 3: column R: 'red'; expected a finite number");
    for (const char* number : {"", " ", "0x1", "1,5", "1.5.2", "1e", "--1", "+-1", "+", "nan",
                               "inf", "-inf", "NaN", "1e999", "1e39", "0.1 0.2", "1;2", "\"1\""})
        EXPECT_NE(with_row(std::string("0.5,0,0.25,3,0.1,") + number), "") << number;
    expects(with_row("0.5,nan,0.25,3,0.1,0.2"), "column phi_i: 'nan'");
    expects(with_row("0.5,0,0.25,3,0.1,1e39"), "column G: '1e39' is too large");
    expects(with_row("0.5,0,0.25,3," + std::string(1000, '7') + "x,0.2"),
            "'7777777777777777777777777777777777777777...'");
}

TEST_F(BadMeasured, angles_below_the_horizon_are_refused) {
    expects(complaint_of(csv_head + "0.5,0,0.25,3,0.1,0.2\n\n1.6,0,0.25,3,0.1,0.2\n"),
            "line 4: column theta_i: '1.6'; expected an angle in [0, pi/2] radians");
    expects(complaint_of(csv_head + "0.5,0,45,3,0.1,0.2\n"), "line 2: column theta_o: '45'");
    expects(complaint_of(csv_head + "-0.1,0,1,3,0.1,0.2\n"), "column theta_i: '-0.1'");
    expects(complaint_of(changed(astm_example, "0.573513", "1.573513")),
            "line 5: column theta_s: '1.573513'");
    expects(complaint_of(changed(cornell_example, "0.6", "2")), "line 11: column theta_i: '2'");
}

TEST_F(BadMeasured, a_negative_weight_is_refused) {
    expects(complaint_of("theta_i,phi_i,theta_o,phi_o,R,weight\n0.5,0,1,3,0.1,-1\n"),
            "line 2: column weight: '-1'; expected 0 or more");
}

TEST_F(BadMeasured, astm_file_is_named_by_line) {
    expects(complaint_of(changed(astm_example, "NUM_POINTS 2", "NUM_POINTS 3")),
            "2 rows; expected 3 as NUM_POINTS says");
    expects(complaint_of(changed(astm_example, "S 2", "S 99999999999999999")), "expected");
    expects(complaint_of(changed(astm_example, "S 2", "S 99999999999999999999999")),
            "line 2: NUM_POINTS: '99999999999999999999999'; expected a whole number");
    expects(complaint_of(changed(astm_example, "S 2", "S -2")), "line 2: NUM_POINTS: '-2'");
    expects(complaint_of(changed(astm_example, "S 2", "S")), "line 2: NUM_POINTS: ''");
    expects(complaint_of(changed(astm_example, "VARS", "VARIABLES")), "no line VARS");
    expects(complaint_of(changed(astm_example, "phi_s", "phi")),
            "line 3: column 'phi_s' is missing");
    expects(complaint_of(changed(astm_example, "0.011364", "bright")),
            "line 5: column R: 'bright'");
    expects(complaint_of(changed(astm_example, ",0.011364", "")), "line 5: 5 fields; expected 6");
    expects(complaint_of("NUM_POINTS 0\nVARS theta_i,phi_i,theta_s,phi_s,R\n"), "no samples");
}

TEST_F(BadMeasured, cornell_file_is_named_by_line) {
    expects(complaint_of("# num wls\n"), "unknown format");
    expects(complaint_of(changed(cornell_example, "\n3\n", "\n0\n")), "no wavelengths");
    expects(complaint_of(changed(cornell_example, "\n3\n", "\n-3\n")),
            "line 2: number of wavelengths: '-3'");
    expects(complaint_of(changed(cornell_example, "\n3\n", "\n2\n")),
            "line 6: 1 fields; expected 6");
    expects(complaint_of(changed(cornell_example, "\n3\n", "\n1\n")),
            "line 5: 2 wavelengths; expected 1");
    expects(complaint_of(changed(cornell_example, "\n3\n", "\n4\n")),
            "line 10: wavelength '0.0'; expected a positive number");
    expects(complaint_of(changed(cornell_example, "\n3\n", "\n99999999999999\n")), "expected");
    expects(complaint_of(changed(cornell_example, "450", "blue")), "line 5: ");
    expects(complaint_of(changed(cornell_example, "450", "-450")), "a positive number");
    expects(complaint_of(changed(cornell_example, "450", "400")), "two columns");
    expects(complaint_of(changed(cornell_example, " 0.7", "")), "line 11: 6 fields; expected 7");
    expects(complaint_of(changed(cornell_example, " 0.7", " nan")), "line 11: column 500: 'nan'");
    expects(complaint_of(cornell_example.substr(0, cornell_example.find("0.5"))), "no samples");
}

TEST_F(BadMeasured, channel_names_that_no_csv_can_hold_are_refused) {
    write_file(path, csv_example);
    for (const char* name : {"", "a,b", "a\nb", " a", "\"a\"", "\xff", "phi_i", "weight", "G"}) {
        Samples samples = read_samples(path);
        samples.channels[0] = name;
        const std::string out = folder / "out.csv";
        EXPECT_NE(complaint([&] { write_samples(samples, out); }), "") << name;
        EXPECT_FALSE(std::filesystem::exists(out));
    }
}

TEST_F(BadMeasured, output_that_cannot_be_written_is_an_error) {
    write_file(path, "theta_i,phi_i,theta_o,phi_o,R,G,B\n0.5,0,0.25,3,1,2,3\n");
    const Samples samples = read_samples(path);
    for (const std::string ending : {".csv", ".npy", ".binary"}) {
        const std::string below_a_file = path + "/out" + ending;
        EXPECT_NE(complaint([&] { write_samples(samples, below_a_file); }).find("cannot write"),
                  std::string::npos);
        EXPECT_NE(complaint([&] { write_samples(samples, folder / "no/out" + ending); }), "");
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

TEST_F(BadMeasured, exit_status_tells_input_from_usage) {
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

// A format that says how much there is refuses less; of the others the whole lines are read.
TEST_F(BadMeasured, every_cut_is_read_or_refused) {
    for (const std::string& example : {csv_example, cornell_example}) {
        const std::size_t end_of_first = example.rfind('\n', example.size() - 2);
        for (std::size_t size = 1; size < example.size(); ++size) {
            const std::size_t count = read_or_refused(example.substr(0, size));
            EXPECT_LE(count, size > end_of_first + 1 ? 2U : 1U) << size;
            if (size == end_of_first || size == end_of_first + 1) {
                EXPECT_EQ(count, 1U) << size;
            }
            if (size + 1 == example.size()) {
                EXPECT_EQ(count, 2U) << "without the last line's end";
            }
        }
    }
    const std::size_t last_comma = astm_example.rfind(',');
    for (std::size_t size = 1; size < astm_example.size(); ++size) {
        const std::size_t count = read_or_refused(astm_example.substr(0, size));
        EXPECT_TRUE(count == 0 || size > last_comma + 1) << size;
    }
    const std::string merl = merl_header(90, 90, 180) + std::string(200, '\0');
    for (std::size_t size = 1; size < merl.size(); ++size)
        EXPECT_EQ(read_or_refused(merl.substr(0, size)), 0U) << size;
}

TEST_F(BadMeasured, mutated_files_are_read_or_refused) {
    int refused = 0;
    for (const std::string& example : {csv_example, astm_example, cornell_example,
                                       merl_header(90, 90, 180) + std::string(200, '\0')}) {
        Mutations mutations(example);
        for (int i = 0; i < 1000; ++i)
            refused += read_or_refused(mutations.next()) == 0;
    }
    EXPECT_GT(refused, 2000);
    EXPECT_LT(refused, 4000);
}

} // namespace

} // namespace brdfit
