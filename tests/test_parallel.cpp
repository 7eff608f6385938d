// Work on all cores: every piece once, exceptions, and systems that give no threads.

#include "host/parallel.hpp"
#include "tests/support/support.hpp"

#include <algorithm>
#include <cstdlib>
#include <gtest/gtest.h>
#include <stdexcept>

namespace brdfit {

namespace {

// How often each of `count` is met.
std::vector<int> met(std::size_t count, std::size_t piece) {
    std::vector<int> times(count);
    parallel_pieces(count, piece, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            ++times[i];
    });
    return times;
}

TEST(ParallelPieces, meet_everything_once) {
    for (const std::size_t count : {0U, 1U, 7U, 8U, 10000U})
        for (const std::size_t piece : {1U, 8U, 100000U})
            EXPECT_EQ(met(count, piece), std::vector<int>(count, 1)) << count << " by " << piece;
}

TEST(ParallelPieces, an_exception_of_a_piece_comes_out) {
    EXPECT_THROW(parallel_pieces(1000, 1,
                                 [](std::size_t begin, std::size_t) {
                                     if (begin == 500)
                                         throw std::runtime_error("piece 500");
                                 }),
                 std::runtime_error);
}

#ifndef __SANITIZE_ADDRESS__ // which needs all addresses
TEST(ParallelPieces, are_done_where_the_system_gives_no_threads) {
    // A new process: this one keeps the stacks of threads that have ended.
    testing::GTEST_FLAG(death_test_style) = "threadsafe";
    const auto without_threads = [] {
        test::limit_memory(std::size_t{1} << 20); // less than a thread's stack
        bool none = false;
        try {
            std::thread([] {}).join();
        } catch (const std::system_error&) {
            none = true;
        }
        std::exit(none && met(10000, 8) == std::vector<int>(10000, 1) ? 0 : 1);
    };
    EXPECT_EXIT(without_threads(), testing::ExitedWithCode(0), "");
}
#endif

} // namespace

} // namespace brdfit
