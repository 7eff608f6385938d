#pragma once

#include "fit/report/overview.hpp"

#include <string>

// The tables of the page, as HTML.

namespace brdfit {

std::string settings_html(const Results& results);
/// Notes and failed fits; empty where there are none.
std::string troubles_html(const Results& results);
/// A row a model: in how many materials it is the best, mean errors by lobes, and by how much the
/// second and third lobe lower them (the multi-lobe table of Kurt et al. 2010).
std::string models_html(const Overview& overview);
/// Errors, material by model, a table for each number of lobes.
std::string errors_html(const Overview& overview);

/// An error with four digits.
std::string error_text(double error);
/// Where a material's card is.
std::string card_id(std::size_t material);

} // namespace brdfit
