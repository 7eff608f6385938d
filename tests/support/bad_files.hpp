#pragma once

#include "tests/support/examples.hpp"
#include "tests/support/support.hpp"

#include <gtest/gtest.h>
#include <random>
#include <string>

// What the tests of broken files share.

namespace brdfit::test {

/// The text with the first `from` replaced by `to`.
std::string changed(std::string text, const std::string& from, const std::string& to);

/// A file's bytes with a few of them changed, removed, inserted or repeated, another way each time.
class Mutations {
  public:
    explicit Mutations(std::string example) : example_(std::move(example)) {}
    std::string next();

  private:
    std::size_t below(std::size_t n) { return random_() % n; }
    std::string example_;
    std::mt19937 random_{20240229};
};

/// Whether a message begins with the file's name and has that part.
void expect_complaint(const std::string& message, const std::string& path, const std::string& part);

} // namespace brdfit::test
