#pragma once

#include "host/model/material.hpp"
#include "host/model/structure.hpp"

#include <string>
#include <vector>

// Structures from the names that a user gives.

namespace brdfit {

/// The structure that model names of the command line mean: `names` joined by '+' gives lobes,
/// a coupled model its diffuse shape too; `lambert` none. `diffuse`: the diffuse shape asked for,
/// or empty. Throws UsageError for unknown names and combinations that do not fit together.
Structure structure_named(const std::string& names, int lobes, const std::string& diffuse,
                          bool isotropic);
/// The structures of several names and numbers of lobes, each once, fewer lobes first. `all` among
/// the names means every listed model that goes with the diffuse shape. Throws UsageError like
/// structure_named, and where nothing is left.
std::vector<Structure> structures_named(const std::vector<std::string>& models,
                                        std::vector<int> lobes, const std::string& diffuse,
                                        bool isotropic);

/// Throws UsageError where a material to start from has not the lobes and diffuse shape of a
/// structure.
void check_start(const Material& start, const Structure& structure);

} // namespace brdfit
