#pragma once

#include "host/cli/command.hpp"
#include "host/cli/isotropy.hpp"
#include "host/microfacet/generator.hpp"

#include <string>
#include <vector>

namespace brdfit::cli {

/// What `brdfit generate --from` is asked to do.
struct RecoverRequest {
    std::string file;
    std::vector<std::string> models{"all"}; ///< to compare with; `none`
    double max_theta = 80;                  ///< degrees
    Isotropy isotropy;
    bool force = false; ///< replace a material that is there
};

void add_recover_options(CLI::App& command, RecoverRequest& request);

/// Recovers a distribution, writes its table and the material beside it, and prints its errors
/// beside those of the models asked for. Returns the exit status.
int recover_from(const RecoverRequest& request, const GeneratorOptions& options,
                 const Generator& generator, const Device& device, const std::string& out,
                 bool json, const Globals& globals);

} // namespace brdfit::cli
