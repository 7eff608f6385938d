#pragma once

#include <CLI/CLI.hpp>
#include <optional>

namespace brdfit::cli {

/// --isotropic and --anisotropic: what scattered data is taken for, whatever its azimuths say.
struct Isotropy {
    bool isotropic = false, anisotropic = false;

    void add_to(CLI::App& command) {
        auto* flag = command.add_flag("--isotropic", isotropic, "take scattered data as isotropic");
        command.add_flag("--anisotropic", anisotropic, "take scattered data as anisotropic")
            ->excludes(flag);
    }
    /// What was asked for, if anything.
    std::optional<bool> choice() const {
        return isotropic || anisotropic ? std::optional(isotropic) : std::nullopt;
    }
};

} // namespace brdfit::cli
