#include "fit/report/overview.hpp"

#include <algorithm>
#include <limits>
#include <set>

namespace brdfit {

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

std::size_t counted(std::size_t lobes) {
    return std::max<std::size_t>(1, lobes);
}

} // namespace

Overview::Overview(const Results& results) : results_(&results) {
    std::set<std::size_t> lobes;
    std::map<std::string, std::size_t> fewest; // lobes, of each model
    const auto note = [&](const std::string& model, std::size_t count) {
        lobes.insert(counted(count));
        const auto [known, fresh] = fewest.emplace(model, counted(count));
        known->second = std::min(known->second, counted(count));
    };
    for (const ReportedFit& fit : results.fits) {
        note(fit.result.model, fit.lobes());
        fits_[{fit.material, fit.result.model, counted(fit.lobes())}] = &fit;
    }
    for (std::size_t i = 0; i < results.failures.size(); ++i) {
        const ReportedFailure& failure = results.failures[i];
        if (failure.model.empty())
            continue;
        note(failure.model, failure.lobes);
        failures_[{failure.material, failure.model, counted(failure.lobes)}] = i;
    }
    lobes_.assign(lobes.begin(), lobes.end());
    std::vector<std::tuple<std::size_t, double, std::string>> order;
    for (const auto& [model, count] : fewest) {
        const double error = mean({model, count});
        order.emplace_back(count, error >= 0 ? error : std::numeric_limits<double>::infinity(),
                           model);
    }
    std::sort(order.begin(), order.end());
    for (const auto& [count, error, model] : order)
        models_.push_back(model);
}

bool Overview::has(const Column& column) const {
    for (std::size_t m = 0; m < results_->materials.size(); ++m)
        if (fit(m, column) != nullptr || failure(m, column))
            return true;
    return false;
}

const ReportedFit* Overview::fit(std::size_t material, const Column& column) const {
    const auto found = fits_.find({material, column.model, column.lobes});
    return found == fits_.end() ? nullptr : found->second;
}

std::optional<std::size_t> Overview::failure(std::size_t material, const Column& column) const {
    const auto found = failures_.find({material, column.model, column.lobes});
    return found == failures_.end() ? std::nullopt : std::optional(found->second);
}

const ReportedFit* Overview::best(std::size_t material, std::size_t lobes) const {
    const ReportedFit* best = nullptr;
    for (auto at = fits_.lower_bound({material, "", 0});
         at != fits_.end() && std::get<0>(at->first) == material; ++at)
        if ((lobes == 0 || std::get<2>(at->first) == lobes) &&
            (best == nullptr || at->second->error() < best->error()))
            best = at->second;
    return best;
}

double Overview::mean(const Column& column) const {
    double sum = 0, count = 0;
    for (std::size_t m = 0; m < results_->materials.size(); ++m)
        if (const ReportedFit* const known = fit(m, column)) {
            sum += known->error();
            ++count;
        }
    return count > 0 ? sum / count : unknown;
}

std::size_t Overview::wins(const Column& column) const {
    std::size_t count = 0;
    for (std::size_t m = 0; m < results_->materials.size(); ++m) {
        const ReportedFit* const known = fit(m, column);
        count += known != nullptr && known == best(m, column.lobes) ? 1 : 0;
    }
    return count;
}

double Overview::gain(const Column& column) const {
    double sum = 0, count = 0;
    for (std::size_t m = 0; m < results_->materials.size(); ++m) {
        const ReportedFit* const more = fit(m, column);
        const ReportedFit* const less = fit(m, {column.model, column.lobes - 1});
        if (more == nullptr || less == nullptr || less->lobes() == 0 || !(less->error() > 0))
            continue;
        sum += 1 - more->error() / less->error();
        ++count;
    }
    return count > 0 ? sum / count : unknown;
}

} // namespace brdfit
