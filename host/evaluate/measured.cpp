#include "host/evaluate/measured.hpp"

#include "host/error.hpp"
#include "host/evaluate/grid.hpp"
#include "host/evaluate/rgl.hpp"
#include "host/measured/formats.hpp"
#include "host/measured/merl.hpp"
#include "host/measured/read.hpp"

#include <fmt/format.h>
#include <utility>

namespace brdfit {

MeasuredBrdf::MeasuredBrdf(const std::string& path, std::optional<bool> isotropic)
    : samples_(read_samples(path, isotropic)) {
    if (samples_.valid_count() == 0)
        throw InputError(fmt::format("{}: no valid samples; expected some to evaluate", path));
    const MappedFile file(path);
    if (rgl::recognise(file.bytes())) {
        method_ = Method::Warp;
        tables_ = rgl::read_tables(file);
        file.require_whole();
    } else if (samples_.directions == merl::bin_directions()) {
        method_ = Method::Merl;
    } else if (utia::recognise(file.bytes())) {
        method_ = Method::Utia;
    } else {
        scattered_.emplace(samples_);
    }
}

MeasuredBrdf::MeasuredBrdf(Samples samples) : samples_(std::move(samples)) {
    if (samples_.valid_count() == 0)
        throw InputError(
            fmt::format("{}: no valid samples; expected some to evaluate", samples_.source));
    scattered_.emplace(samples_);
}

const char* MeasuredBrdf::method() const {
    switch (method_) {
    case Method::Warp:
        return "by its warp";
    case Method::Merl:
    case Method::Utia:
        return "linear between its nodes";
    case Method::Scattered:
        break;
    }
    return "Shepard's mean of the 8 nearest samples";
}

std::vector<float> MeasuredBrdf::evaluate(const Device& device, const Directions& directions,
                                          const ProgressFunction& progress) const {
    switch (method_) {
    case Method::Warp:
        return brdfit::evaluate(device, *tables_, directions, progress);
    case Method::Merl:
        return evaluate_merl(samples_, directions, progress);
    case Method::Utia:
        return evaluate_utia(samples_, directions, progress);
    case Method::Scattered:
        break;
    }
    return scattered_->evaluate(directions, progress);
}

} // namespace brdfit
