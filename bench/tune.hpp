#pragma once

#include "bench/work.hpp"
#include "host/device/device.hpp"
#include "host/measured/samples.hpp"

#include <functional>
#include <vector>

namespace brdfit::bench {

/// The forms worth trying on a device, the shipped one first: where it runs vectors every width
/// from 4, otherwise every local size from 64, each with several block sizes and candidates a pass.
std::vector<Form> forms_for(const Device& device);

/// What a form makes of the works that depend on it most.
struct Tried {
    Form form;
    double eval = 0, gradient = 0, search = 0; ///< samples a second of `kurt`
    double slowness = 0;                       ///< geometric mean of times, the shipped form's = 1
};

/// Measures the forms on `data` (see data_of), the first of which is the one others are compared
/// with; `next` is called before each. Throws InputError where a form gives wrong answers.
std::vector<Tried> try_forms(const Device& device, const std::vector<Form>& forms,
                             const Samples& data, const std::function<void(std::size_t)>& next);

} // namespace brdfit::bench
