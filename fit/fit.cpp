#include "fit/fit.hpp"

#include "fit/programs.hpp"
#include "fit/structures.hpp"
#include "host/error.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <fmt/format.h>
#include <utility>

namespace brdfit {

namespace {

// Samples the global search looks at.
constexpr std::size_t thinned_count = 16384;
// Starting points polished on the thinned samples, then on all.
constexpr std::size_t single_lobe_starts = 6, several_lobe_starts = 16;
// Where the metric is not quadratic the search's ranking is rough: as many random points are ranked
// by the metric itself, the best of which are polished too.
constexpr std::size_t single_lobe_draws = 64, several_lobe_draws = 192;
constexpr std::uint64_t draw_seed = 0x6a7d; // not that of --starts
constexpr std::size_t single_lobe_drawn = 4, several_lobe_drawn = 10;
constexpr std::size_t single_lobe_finalists = 2, several_lobe_finalists = 3;
constexpr double highest_coupled_f0 = 0.999;
// Squared errors that differ by less than this share are equal, up to rounding.
constexpr double equal_share = 1e-7;

double seconds_since(std::chrono::steady_clock::time_point started) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - started).count();
}

// The rank of a lobe among those of its model: broad ones first.
double breadth(const Model& model, bool isotropic, const double* theta) {
    const std::vector<Parameter>& parameters = model.parameters(isotropic);
    for (std::size_t i = 0; i < parameters.size(); ++i) {
        if (parameters[i].scale == Scale::Log)
            return theta[i];
        if (parameters[i].scale == Scale::Log1p)
            return -theta[i];
    }
    return 0;
}

// Turned frames that are the same are alike here: the angle is within (-90, 90], and the first of
// the two roughnesses is the broader, that of another quarter of a turn. Not where --bound or --fix
// tells them apart.
void order_frames(const Structure& structure, const Space& space, std::vector<double>& theta) {
    const StructureLayout layout = layout_of(structure);
    for (std::size_t l = 0; l < structure.lobes.size(); ++l) {
        if (!structure.lobes[l]->turns)
            continue;
        const Space lobe = space.of_lobe(static_cast<int>(l));
        const auto& d = lobe.dimensions();
        double* const own = &theta[static_cast<std::size_t>(layout.lobe_begin[l])];
        double& angle = own[d.size() - 1];
        const Parameter& range = d.back().parameter;
        if (range.upper - range.lower < 360)
            continue;
        const std::optional<std::size_t> x = exchangeable(lobe);
        if (x &&
            (d[*x].parameter.scale == Scale::Log ? own[*x] < own[*x + 1] : own[*x] > own[*x + 1])) {
            std::swap(own[*x], own[*x + 1]);
            angle += 90;
        }
        angle -= 180 * std::ceil(angle / 180 - 0.5);
    }
}

// Lobes of one model are interchangeable: the broadest comes first. The first lobe of a coupled
// material stays: the diffuse shape has its F.
void order_lobes(const Structure& structure, const Space& space, std::vector<double>& theta,
                 Coefficients& a) {
    order_frames(structure, space, theta);
    const StructureLayout layout = layout_of(structure);
    const std::size_t lobes = structure.lobes.size();
    const auto begin = [&](std::size_t l) {
        return static_cast<std::size_t>(layout.lobe_begin[l]);
    };
    const auto same_ranges = [&](std::size_t p, std::size_t q) {
        const auto& d = space.dimensions();
        for (std::size_t i = 0; i < begin(p + 1) - begin(p); ++i)
            if (d[begin(p) + i].parameter.lower != d[begin(q) + i].parameter.lower ||
                d[begin(p) + i].parameter.upper != d[begin(q) + i].parameter.upper)
                return false;
        return true;
    };
    for (std::size_t i = structure.coupled() ? 1 : 0; i < lobes; ++i)
        for (std::size_t k = i + 1; k < lobes; ++k) {
            if (structure.lobes[i] != structure.lobes[k] || !same_ranges(i, k))
                continue;
            const Model& model = *structure.lobes[i];
            if (breadth(model, structure.isotropic, &theta[begin(i)]) >=
                breadth(model, structure.isotropic, &theta[begin(k)]))
                continue;
            std::swap_ranges(theta.begin() + layout.lobe_begin[i],
                             theta.begin() + layout.lobe_begin[i + 1],
                             theta.begin() + layout.lobe_begin[k]);
            a.col(static_cast<Eigen::Index>(i) + 1).swap(a.col(static_cast<Eigen::Index>(k) + 1));
        }
}

// What a fit without one lobe may lack: the mirror image of a turned lobe that it has. Lobes as
// sharp as a grating's orders are between the search's angles, and come in such pairs.
void add_mirrored(const Structure& structure, const PartialFit& fit,
                  std::vector<StartingPoint>& starts) {
    const StructureLayout layout = layout_of(structure);
    const auto missing = static_cast<std::size_t>(fit.missing);
    if (!structure.lobes[missing]->turns)
        return;
    auto own = fit.theta.begin();
    for (std::size_t l = 0; l < structure.lobes.size(); ++l) {
        if (l == missing)
            continue;
        const auto end = own + (layout.lobe_begin[l + 1] - layout.lobe_begin[l]);
        if (structure.lobes[l] == structure.lobes[missing]) {
            StartingPoint start{fit.theta, 0};
            const auto added =
                start.theta.insert(start.theta.begin() + layout.lobe_begin[missing], own, end);
            *(added + (end - own) - 1) *= -1;
            starts.push_back(std::move(start));
        }
        own = end;
    }
}

Material material_of(const Structure& structure, const std::vector<std::string>& channels,
                     const std::vector<double>& theta, const Coefficients& a) {
    const StructureLayout layout = layout_of(structure);
    Material material;
    material.channels = channels;
    material.diffuse = structure.diffuse;
    const auto column = [&](std::size_t j) {
        const Eigen::VectorXd values = a.col(static_cast<Eigen::Index>(j));
        return std::vector<double>(values.data(), values.data() + values.size());
    };
    material.kd = column(0);
    for (std::size_t l = 0; l < structure.lobes.size(); ++l)
        material.lobes.push_back(
            {structure.lobes[l],
             structure.isotropic,
             {theta.begin() + layout.lobe_begin[l], theta.begin() + layout.lobe_begin[l + 1]},
             column(l + 1)});
    return material;
}

} // namespace

FileFitter::FileFitter(const Device& device, ProgramCache& programs, const Samples& samples,
                       const FitOptions& options)
    : FileFitter(device, programs, samples, options,
                 pack_samples(device, samples, options.max_theta, options.metric)) {}

FileFitter::FileFitter(const Device& device, ProgramCache& programs, const Samples& samples,
                       const FitOptions& options, DeviceSamples packed)
    : device_(device), programs_(programs), samples_(samples), options_(options),
      shared_(std::make_shared<Shared>()), packed_(shared_->packed), thinned_(shared_->thinned) {
    shared_->packed = std::move(packed);
    shared_->thinned = thin_samples(device, samples, packed_, options.metric, thinned_count);
    // Objectives have copies of these.
    shared_->packed.used = shared_->thinned.used = {};
}

Objective& FileFitter::thinned_objective(const Structure& structure) {
    std::unique_ptr<Objective>& objective = thinned_objectives_[structure.key()];
    if (!objective)
        objective = std::make_unique<Objective>(
            device_, programs_.get(structure, packed_.channels, packed_.chunk), thinned_, nullptr,
            options_.abandon);
    return *objective;
}

Polish FileFitter::full_polish(const Structure& structure, const Space& space) {
    MinimiseOptions options;
    options.algorithm = options_.algorithm;
    options.max_evaluations = options_.max_evaluations;
    options.seed = options_.seed;
    return {full_objective(structure), space, options_.metric, options};
}

std::vector<FileFitter::Smaller> FileFitter::smaller_than(const Structure& structure) const {
    std::vector<Smaller> parts;
    const bool by_lobe = std::any_of(options_.ranges.begin(), options_.ranges.end(),
                                     [](const ParameterRange& range) { return range.lobe != 0; });
    for (std::size_t missing = structure.lobes.size();
         structure.lobes.size() > 1 && missing-- > 0;) {
        // One of each model; ranges of a single lobe, and a coupled first lobe, would not carry
        // over.
        const bool last_of_model =
            std::find(structure.lobes.begin() + static_cast<std::ptrdiff_t>(missing) + 1,
                      structure.lobes.end(), structure.lobes[missing]) == structure.lobes.end();
        const bool last = missing + 1 == structure.lobes.size();
        if (!last_of_model || (missing == 0 && structure.coupled()) || (by_lobe && !last))
            continue;
        Smaller part{static_cast<int>(missing), structure};
        part.structure.lobes.erase(part.structure.lobes.begin() +
                                   static_cast<std::ptrdiff_t>(missing));
        parts.push_back(std::move(part));
    }
    return parts;
}

// The solution of a smaller structure with a missing lobe of no strength.
Solution FileFitter::extended(const Structure& structure, const Space& space, const Smaller& part,
                              const Solution& known) {
    const StructureLayout layout = layout_of(structure);
    const auto missing = static_cast<std::size_t>(part.missing);
    Solution solution{known.theta, Coefficients::Zero(known.a.rows(), known.a.cols() + 1), 0};
    std::vector<double> added;
    for (int p = layout.lobe_begin[missing]; p < layout.lobe_begin[missing + 1]; ++p)
        added.push_back(space.dimensions()[static_cast<std::size_t>(p)].parameter.start);
    solution.theta.insert(solution.theta.begin() + layout.lobe_begin[missing], added.begin(),
                          added.end());
    for (Eigen::Index j = 0; j < known.a.cols(); ++j)
        solution.a.col(j <= part.missing ? j : j + 1) = known.a.col(j);
    return solution;
}

std::vector<StartingPoint> FileFitter::searched_starts(const Structure& structure,
                                                       const Space& space) {
    if (structure.lobes.empty())
        return {{{}, 0}};
    std::vector<PartialFit> partial;
    for (const Smaller& part : smaller_than(structure))
        partial.push_back({part.missing, fitted(part.structure).solution.theta});
    std::vector<Objective*> single;
    for (const Model* lobe : structure.lobes)
        single.push_back(
            &thinned_objective(Structure{structure.diffuse, {lobe}, structure.isotropic}));
    const GramProgram gram = [this]() -> const SharedProgram& { return programs_.gram(); };
    std::vector<StartingPoint> starts =
        search_shapes(device_, gram, single, space, partial,
                      structure.lobes.size() == 1 ? single_lobe_starts : several_lobe_starts);
    for (const PartialFit& fit : partial)
        add_mirrored(structure, fit, starts);
    return starts;
}

// The best of random points by a metric that is not quadratic. The search's quadratic weights know
// nothing of fits far from the data.
std::vector<Solution> FileFitter::drawn_starts(Objective& objective, const Space& space) const {
    const bool several = objective.structure().lobes.size() > 1;
    std::vector<Solution> drawn;
    for (std::size_t i = 0; i < (several ? several_lobe_draws : single_lobe_draws); ++i) {
        Solution draw{space.random(draw_seed, i), {}, 0};
        // A Fresnel term changes most near its lowest f0: half of the lobes have that.
        std::size_t half = i;
        for (std::size_t p = 0; p < draw.theta.size(); ++p) {
            const Parameter& parameter = space.dimensions()[p].parameter;
            if (parameter.name != "f0")
                continue;
            if (half % 2 == 0)
                draw.theta[p] = parameter.lower;
            half /= 2;
        }
        draw.squared_error = objective.projected_loss(options_.metric, draw.theta, draw.a);
        if (std::isfinite(draw.squared_error))
            drawn.push_back(std::move(draw));
    }
    std::stable_sort(drawn.begin(), drawn.end(), better);
    drawn.resize(std::min(drawn.size(), several ? several_lobe_drawn : single_lobe_drawn));
    return drawn;
}

std::vector<Solution> FileFitter::polished_thinned(const Structure& structure, const Space& space,
                                                   const std::vector<StartingPoint>& starts) {
    Objective& objective = thinned_objective(structure);
    std::vector<Solution> solutions;
    for (const StartingPoint& start : starts)
        solutions.push_back({space.clamped(start.theta), {}, start.squared_error});
    if (!quadratic(options_.metric) && !structure.lobes.empty())
        for (Solution& drawn : drawn_starts(objective, space))
            solutions.push_back(std::move(drawn));
    Polish polish = thinned_polish(structure, space);
    for (Solution& solution : solutions)
        solution = thinned_minimum(polish, structure, space, solution);
    std::stable_sort(solutions.begin(), solutions.end(), better);
    return solutions;
}

Polish FileFitter::thinned_polish(const Structure& structure, const Space& space) {
    MinimiseOptions options;
    options.max_evaluations = 100;
    options.relative_tolerance = 1e-6;
    return {thinned_objective(structure), space, options_.metric, options};
}

Solution FileFitter::thinned_minimum(Polish& polish, const Structure& structure, const Space& space,
                                     const Solution& start) {
    Solution solution = polish.descended(start);
    if (std::isfinite(solution.squared_error)) // so that alike() tells twins
        order_lobes(structure, space, solution.theta, solution.a);
    return solution;
}

std::size_t FileFitter::finalist_count(const Structure& structure) {
    return structure.lobes.size() <= 1 ? single_lobe_finalists : several_lobe_finalists;
}

std::vector<Solution> FileFitter::distinct(const Space& space,
                                           const std::vector<Solution>& solutions,
                                           std::size_t count) {
    std::vector<Solution> chosen;
    for (const Solution& solution : solutions) {
        if (chosen.size() == count)
            break;
        if (std::none_of(chosen.begin(), chosen.end(), [&](const Solution& other) {
                return alike(space, solution.theta, other.theta);
            }))
            chosen.push_back(solution);
    }
    return chosen;
}

bool FileFitter::alike(const Space& space, const std::vector<double>& a,
                       const std::vector<double>& b) {
    const std::vector<double> x = space.to_x(a), y = space.to_x(b);
    double distance = 0;
    for (std::size_t i = 0; i < x.size(); ++i)
        distance = std::max(distance, std::abs(x[i] - y[i]));
    return distance < 0.02;
}

const Material* FileFitter::start_of(const Structure& structure) const {
    const bool whole = options_.start && options_.start->lobes.size() == structure.lobes.size();
    return whole ? &*options_.start : nullptr;
}

std::vector<double> FileFitter::theta_of(const Material& start, const Structure& structure,
                                         const Space& space) const {
    std::vector<double> theta;
    for (std::size_t l = 0; l < start.lobes.size(); ++l) {
        const Lobe& lobe = start.lobes[l];
        std::vector<double> values = lobe.theta;
        if (lobe.isotropic && !structure.isotropic)
            values = lobe.anisotropic_theta();
        else if (!lobe.isotropic && structure.isotropic &&
                 lobe.theta.size() != lobe.model->isotropic.size())
            throw UsageError(fmt::format(
                "--start: its {} lobe is anisotropic, the data is isotropic", lobe.model->name));
        if (structure.lobes[l]->turns && !lobe.model->turns)
            values.push_back(0);
        else if (lobe.model->turns && !structure.lobes[l]->turns)
            throw UsageError(fmt::format("--start: its {} lobe has an orientation; expected "
                                         "--orient, which fits that too",
                                         lobe.model->name));
        theta.insert(theta.end(), values.begin(), values.end());
    }
    const Space given(structure.lobes, structure.isotropic, options_.ranges);
    if (given.clamped(theta) != theta)
        throw UsageError("--start: a parameter is outside the bounds given");
    return space.clamped(theta);
}

bool FileFitter::has_pull(const Structure& structure, const Solution& start) {
    Objective& objective = thinned_objective(structure);
    objective.projected_error(start.theta);
    const Coefficients& a = objective.coefficients();
    for (Eigen::Index j = 1; j < a.cols(); ++j)
        if (!(a.col(j).maxCoeff() > 0))
            return false;
    return true;
}

Space FileFitter::space_of(const Structure& structure) const {
    std::vector<ParameterRange> ranges = options_.ranges;
    const bool f0_is_given = std::any_of(ranges.begin(), ranges.end(), [](const ParameterRange& r) {
        return r.name == "f0" && r.lobe <= 1;
    });
    // At f0 = 1 a coupled diffuse shape vanishes, so that no kd is the best and none can be found.
    if (structure.coupled() && !f0_is_given)
        ranges.push_back({"f0", 1, 0, highest_coupled_f0, false});
    return Space(structure.lobes, structure.isotropic, ranges);
}

void FileFitter::build_programs(const Structure& structure) {
    programs_.get(structure, packed_.channels, packed_.chunk);
    for (const Model* lobe : structure.lobes)
        programs_.get({structure.diffuse, {lobe}, structure.isotropic}, packed_.channels,
                      packed_.chunk);
    if (structure.lobes.size() > 1)
        programs_.gram();
}

std::vector<Solution> FileFitter::finalists(const Structure& structure, const Space& space) {
    std::vector<Solution> finalists;
    if (const Material* const start = start_of(structure)) {
        finalists.push_back({theta_of(*start, structure, space), {}, 0});
        if (has_pull(structure, finalists.front()))
            return finalists;
    }
    const std::vector<StartingPoint> starts = searched_starts(structure, space);
    const std::vector<Solution> solutions = polished_thinned(structure, space, starts);
    const std::vector<Solution> best = distinct(space, solutions, finalist_count(structure));
    finalists.insert(finalists.end(), best.begin(), best.end());
    return finalists;
}

// Where the default algorithm leads, the Levenberg-Marquardt method gets there sooner: NLopt starts
// at the best of its results.
Solution FileFitter::best_of(Polish& polish, const std::vector<Solution>& starts,
                             double goal) const {
    const bool descends = options_.algorithm == MinimiseOptions{}.algorithm && polish.can_descend();
    Solution best;
    best.squared_error = std::numeric_limits<double>::infinity();
    for (const Solution& start : starts) {
        Solution solution = descends ? polish.descended(start, std::min(goal, best.squared_error))
                                     : polish.minimised(start);
        if (better(solution, best))
            best = std::move(solution);
    }
    if (descends && best.squared_error < goal)
        best = polish.minimised(best);
    return best;
}

Solution FileFitter::best_polished(const Structure& structure, const Space& space,
                                   const std::vector<Solution>& finalists, bool searched) {
    Polish polish = full_polish(structure, space);
    Solution best = best_of(polish, finalists);
    // Never worse than what it extends, which the search has fitted.
    if (searched)
        for (const Smaller& part : smaller_than(structure)) {
            const Solution& known = fitted(part.structure).solution;
            if (known.squared_error >= best.squared_error * (1 - equal_share))
                continue;
            Solution solution = best_of(polish, {extended(structure, space, part, known)});
            if (better(solution, best))
                best = std::move(solution);
        }
    if (!std::isfinite(best.squared_error))
        throw InputError("no finite error on these samples");
    return best;
}

const FileFitter::Fitted& FileFitter::fitted(const Structure& structure) {
    return shared_->fitted.get(structure.key(), [&] { return fit_freely(structure); });
}

FileFitter::Fitted FileFitter::fit_freely(const Structure& structure) {
    Fitted fit;
    fit.space = space_of(structure);
    // Seconds since the last lap, without those spent on programs.
    auto started = std::chrono::steady_clock::now();
    double building = programs_.build_seconds();
    const auto lap = [&] {
        const double before = std::exchange(building, programs_.build_seconds());
        const double seconds = seconds_since(started) - (building - before);
        started = std::chrono::steady_clock::now();
        return seconds;
    };
    build_programs(structure);
    lap();
    const std::vector<Solution> starts = finalists(structure, fit.space);
    const bool searched = start_of(structure) == nullptr || starts.size() > 1;
    fit.thinned_evaluations = searched ? thinned_objective(structure).evaluations() : 0;
    fit.search_seconds = lap();
    fit.solution = best_polished(structure, fit.space, starts, searched);
    fit.polish_seconds = lap();
    const Objective& objective = full_objective(structure);
    fit.evaluations = objective.evaluations();
    fit.passes = objective.timed_passes();
    fit.pass_seconds = objective.seconds();
    return fit;
}

Objective& FileFitter::full_objective(const Structure& structure) {
    if (full_objective_ && full_objective_->structure().key() == structure.key())
        return *full_objective_;
    const std::shared_ptr<const FitProgram> program =
        programs_.get(structure, packed_.channels, packed_.chunk);
    if (full_objective_ && !same_planes(full_objective_->structure(), structure))
        full_objective_.reset(); // its planes first: they may be a gigabyte
    full_objective_ = std::make_unique<Objective>(device_, program, packed_, full_objective_.get(),
                                                  options_.abandon);
    return *full_objective_;
}

FitResult FileFitter::fit(const Structure& structure, const ProgressFunction& progress) {
    const auto started = std::chrono::steady_clock::now();
    const double building = programs_.build_seconds();
    if (options_.start)
        check_start(*options_.start, structure);
    Conserving* const conserved = options_.conserve ? &conserving(structure) : nullptr;
    const Fitted& fit = conserved != nullptr ? conserved->fitted : fitted(structure);
    Objective& objective = full_objective(structure);
    objective.start_near(fit.solution.a); // whatever was fitted, by whichever fitter
    const std::size_t evaluations = objective.evaluations(), passes = objective.timed_passes();
    const double pass_seconds = objective.seconds();
    Solution solution = fit.solution;
    FitResult result;
    if (conserved != nullptr)
        objective.limit_albedos(conserved->limit);
    if (options_.random_starts > 0)
        try_random_starts(structure, fit, conserved, solution, result, progress);
    solution.theta = fit.space.snapped(std::move(solution.theta));
    order_lobes(structure, fit.space, solution.theta, solution.a);
    result.model = structure.name();
    result.errors = objective.metric_errors(solution.theta, solution.a);
    result.parameters = fitted_parameters(objective, fit.space, options_.metric, samples_.channels,
                                          solution.theta, solution.a);
    result.material = material_of(structure, samples_.channels, solution.theta, solution.a);
    result.theta = std::move(solution.theta);
    result.samples = packed_.count;
    const ComponentAlbedos albedos(programs_, structure);
    result.largest_albedo = (options_.conserve ? largest_conserved_albedo : largest_albedo)(
        albedos, samples_.channels, result.theta, solution.a);
    result.evaluations = fit.evaluations + objective.evaluations() - evaluations;
    result.passes = fit.passes + objective.timed_passes() - passes;
    result.pass_seconds = fit.pass_seconds + objective.seconds() - pass_seconds;
    result.thinned_evaluations += fit.thinned_evaluations;
    result.build_seconds = programs_.build_seconds() - building;
    result.search_seconds = fit.search_seconds;
    result.polish_seconds = fit.polish_seconds;
    result.seconds = seconds_since(started) - result.build_seconds;
    return result;
}

} // namespace brdfit
