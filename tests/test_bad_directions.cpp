// What a broken list of directions says, as CSV and as NumPy's array.

#include "host/files/directions.hpp"
#include "tests/support/bad_files.hpp"
#include "tests/support/support.hpp"

#include <cmath>
#include <cstring>
#include <gtest/gtest.h>

namespace brdfit::test {

namespace {

class BadDirections : public testing::Test {
  protected:
    const TemporaryFolder folder;
    const std::string path = folder / "bad file";

    /// What read_directions says of a file with these bytes; empty where it reads them.
    std::string complaint_of(const std::string& bytes) {
        write_file(path, bytes);
        return complaint([&] { read_directions(path); });
    }
    void expects(const std::string& message, const std::string& part) {
        expect_complaint(message, path, part);
    }
};

TEST_F(BadDirections, csv_must_be_unit_vectors) {
    const std::string head = "wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n";
    expects(complaint_of("x,y\n1,2\n"), "unknown format; expected CSV");
    expects(complaint_of(head), "no directions");
    expects(complaint_of("wi_x,wi_y,wi_z,wo_x,wo_y\n"), "'wo_z' is missing");
    expects(complaint_of("wi_x,wi_y,wi_z,wo_x,wo_y,wo_z,R\n"), "line 1: 7 columns");
    expects(complaint_of(head + "0,0,1,0,0\n"), "line 2: 5 fields; expected 6");
    expects(complaint_of(head + "0,0,1,0,0,1\n0,0,1,0,0,1.1\n"), "line 3: wo is not a unit vector");
    expects(complaint_of(head + "0,0,0,0,0,1\n"), "line 2: wi is not a unit vector");
    expects(complaint_of(head + "0,up,1,0,0,1\n"), "line 2: column wi_y: 'up'");
}

TEST_F(BadDirections, npy_must_be_six_columns) {
    EXPECT_EQ(complaint_of(npy_example()), "");
    const auto with = [&](const std::string& from, const std::string& to) {
        std::string bytes = changed(npy_example(), from, to);
        bytes[8] = static_cast<char>(bytes[8] + static_cast<int>(to.size() - from.size()));
        return complaint_of(bytes);
    };
    expects(with("<f4", "<i4"), "expected the type");
    expects(with("<f4", ">f4"), "expected the type");
    expects(with("<f4", "<f8"), "48 bytes of data; expected 2 x 6 values of 8 bytes");
    expects(with("False", "True"), "C order");
    expects(with("False", "0"), "True or False");
    expects(with("(2, 6)", "(3, 6)"), "48 bytes of data; expected 3 x 6");
    expects(with("(2, 6)", "(1, 6)"), "48 bytes of data; expected 1 x 6");
    expects(with("(2, 6)", "(3, 4)"), "3 rows of 4 columns");
    expects(with("(2, 6)", "(12,)"), "1 dimensions; expected 2");
    expects(with("(2, 6)", "()"), "0 dimensions; expected 2");
    expects(with("(2, 6)", "(2, -6)"), "whole number");
    expects(with("(2, 6)", "(0, 6)"), "expected 0 x 6");
    expects(with("(2, 6)", "(12297829382473034411, 6)"), "48 bytes of data");
    expects(with("(2, 6)", "(4611686018427387906, 6)"), "48 bytes of data");
    expects(with("(2, 6)", "(99999999999999999999999, 6)"), "whole number");
    expects(with("'descr'", "'type'"), "unknown key");
    expects(with("'shape': (2, 6), ", ""), "expected descr, fortran_order and shape");
    std::string bytes = npy_example();
    bytes[6] = 4;
    expects(complaint_of(bytes), "version 4");
    bytes[6] = 2; // the length is now four bytes, of which two are text
    expects(complaint_of(bytes), "the file ends inside it");
    for (std::size_t size = 6; size < npy_example().size(); ++size)
        EXPECT_NE(complaint_of(npy_example().substr(0, size)), "") << size;
    const float not_a_number = std::nanf("");
    bytes = npy_example();
    std::memcpy(bytes.data() + bytes.size() - 4, &not_a_number, 4);
    expects(complaint_of(bytes), "row 1: wo is not a unit vector");
}

TEST_F(BadDirections, mutated_files_are_read_or_refused) {
    int refused = 0;
    for (const std::string& example :
         {npy_example(), std::string("wi_x,wi_y,wi_z,wo_x,wo_y,wo_z\n0,0,1,0.6,0,0.8\n")}) {
        Mutations mutations(example);
        for (int i = 0; i < 1000; ++i) {
            const std::string bytes = mutations.next();
            write_file(path, bytes);
            Directions read;
            const std::string message = complaint([&] { read = read_directions(path); });
            if (!message.empty()) {
                EXPECT_EQ(message.find(path + ": "), 0U) << message;
                ++refused;
                continue;
            }
            ASSERT_GT(read.count(), 0U) << bytes;
            ASSERT_EQ(read.data().size(), Directions::plane_count * read.count()) << bytes;
            for (const float x : read.data())
                ASSERT_TRUE(std::isfinite(x)) << bytes;
        }
    }
    EXPECT_GT(refused, 1000);
    EXPECT_LT(refused, 2000);
}

} // namespace

} // namespace brdfit::test
