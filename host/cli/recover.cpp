#include "host/cli/recover.hpp"

#include "host/error.hpp"

namespace brdfit::cli {

void add_recover_options(CLI::App&, RecoverRequest&) {}
int recover_from(const RecoverRequest&, const GeneratorOptions&, const Generator&, const Device&,
                 const std::string&, bool, const Globals&) {
    throw UsageError("later");
}

} // namespace brdfit::cli
