#include "tests/support/bad_files.hpp"

namespace brdfit::test {

std::string changed(std::string text, const std::string& from, const std::string& to) {
    const std::size_t at = text.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    return text.replace(at, from.size(), to);
}

std::string Mutations::next() {
    static const std::string alphabet("0123456789.,-+eE# \r\n\t\0\xff"
                                      "naif",
                                      27);
    std::string bytes = example_;
    for (std::size_t n = 1 + below(4); n > 0 && !bytes.empty(); --n) {
        const std::size_t at = below(bytes.size());
        switch (below(5)) {
        case 0:
            bytes[at] = static_cast<char>(random_());
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
    return bytes;
}

void expect_complaint(const std::string& message, const std::string& path,
                      const std::string& part) {
    EXPECT_NE(message.find(part), std::string::npos) << message;
    EXPECT_EQ(message.find(path + ": "), 0U) << message;
}

} // namespace brdfit::test
