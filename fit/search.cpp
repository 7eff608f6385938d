#include "fit/search.hpp"

#include "host/device/buffer.hpp"
#include "host/parallel.hpp"
#include "kernels/passes/gram.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

namespace brdfit {

namespace {

// Grid points an axis. Two roughnesses share what one has to itself.
constexpr int width_points = 24, paired_width_points = 13;
constexpr int linear_points = 5, paired_linear_points = 3;
constexpr int points_about_one = 13, paired_points_about_one = 7;
// With a turned frame, angles of a quarter turn; of several lobes, whose combinations are many.
constexpr int angle_points = 8, several_angle_points = 3, several_turned_width_points = 9;
// Combinations that get one more lobe, and that have their f0 refined.
constexpr std::size_t beam = 24;
constexpr std::size_t refined = 96;
constexpr int tile = GRAM_TILE;

// A lobe's shape: its rows at the lowest and the highest f0 (equal where f0 is not free).
struct Shape {
    std::vector<double> theta; // f0 at its lowest
    std::vector<int> place;    // on the grid, without f0; empty: off the grid
    int low_row = 0, high_row = 0;
    bool mixed() const { return low_row != high_row; }
};

struct Combination {
    std::vector<int> shapes;    // one a lobe
    std::vector<double> shares; // of the way from the lowest to the highest f0, one a lobe
    double squared_error = 0;
};

// A basis function as a mixture of two rows.
struct Column {
    int low, high;
    double share;
};

struct Columns {
    std::array<Column, max_unknowns> column;
    int count = 0;
    void add(const Column& c) { column[static_cast<std::size_t>(count++)] = c; }
    const Column& at(int i) const { return column[static_cast<std::size_t>(i)]; }
};

class Search {
  public:
    Search(const Device& device, const GramProgram& gram_program,
           const std::vector<Objective*>& single, const Space& space,
           const std::vector<PartialFit>& partial);
    std::vector<StartingPoint> best(std::size_t count) const;

  private:
    struct Range {
        int begin, end;
    };
    Range add_grid(Objective& objective, const Space& space, bool several);
    Combination add_given(const PartialFit& fit, const std::vector<Objective*>& single);
    int add_shape(Shape shape, bool mixed);
    void fill_gram(const Device& device, const SharedProgram& gram_program,
                   const std::vector<Objective*>& single);
    void fill_gram_of_one_lobe(Objective& objective);
    double inner(const Column& a, const Column& b) const;
    double solve(const Columns& columns, SmallVector& strengths) const;
    double relaxed(Combination& combination, unsigned added) const;
    void refine(Combination& combination) const;
    template <typename Make>
    std::vector<Combination> best_of(std::size_t count, unsigned added, Make make) const;
    std::vector<Combination> extended(const std::vector<Combination>& base, std::size_t lobe) const;
    std::vector<Combination> best_sets() const;
    bool neighbours(const Combination& a, const Combination& b) const;
    StartingPoint start_of(const Combination& combination) const;

    int channels_, rows_ = 0;
    double norm_;
    std::vector<Space> spaces_;         // one a lobe
    std::vector<Range> grid_;           // shapes of each lobe
    std::vector<Objective*> objective_; // one a shape
    std::vector<Shape> shapes_;
    std::vector<Combination> given_; // partial fits: the missing lobe is -1
    Eigen::MatrixXd gram_;           // [row][row]: channels, diffuse, shapes
};

bool has_free_f0(const Space& lobe) {
    const auto& dimensions = lobe.dimensions();
    return !dimensions.empty() && dimensions[0].parameter.name == "f0" && !dimensions[0].fixed;
}

bool same_ranges(const Space& a, const Space& b) {
    return std::equal(
        a.dimensions().begin(), a.dimensions().end(), b.dimensions().begin(), b.dimensions().end(),
        [](const Space::Dimension& x, const Space::Dimension& y) {
            return x.parameter.lower == y.parameter.lower && x.parameter.upper == y.parameter.upper;
        });
}

bool has_free_angle(const Space& lobe) {
    const auto& dimensions = lobe.dimensions();
    return !dimensions.empty() && dimensions.back().parameter.scale == Scale::Angle &&
           !dimensions.back().fixed;
}

// Half a turn is the same again, a quarter what exchanging the roughnesses does.
std::vector<double> angles(const Space& lobe, double low, double high, bool several) {
    const bool all = high - low >= 2 * pi;
    const bool quarter = all && exchangeable(lobe);
    const double span = std::min(high - low, quarter ? pi / 2 : pi);
    const int points = (several ? several_angle_points : angle_points) * (quarter ? 1 : 2);
    std::vector<double> axis;
    for (int k = 0; k < points; ++k)
        axis.push_back((all ? 0 : low) + span * k / points);
    return axis;
}

// The points of each dimension's axis in x; f0 has its lowest value alone.
std::vector<std::vector<double>> axes_of(const Space& lobe, bool several) {
    const bool fewer = several && has_free_angle(lobe);
    const auto free = [&](auto is) {
        return std::count_if(
            lobe.dimensions().begin(), lobe.dimensions().end(),
            [&](const Space::Dimension& d) { return !d.fixed && is(d.parameter); });
    };
    const auto widths = free([](const Parameter& p) { return p.width(); });
    const auto axes_about_one = free([](const Parameter& p) { return p.scale == Scale::AboutOne; });
    std::vector<std::vector<double>> axes;
    for (std::size_t i = 0; i < lobe.dimensions().size(); ++i) {
        const Space::Dimension& dimension = lobe.dimensions()[i];
        const Parameter& p = dimension.parameter;
        const bool f0 = i == 0 && p.name == "f0";
        const bool paired = p.scale == Scale::AboutOne ? axes_about_one > 1 : widths > 1;
        int points = paired ? paired_linear_points : linear_points;
        if (p.width())
            points = fewer    ? several_turned_width_points
                     : paired ? paired_width_points
                              : width_points;
        else if (p.scale == Scale::AboutOne)
            points = paired ? paired_points_about_one : points_about_one;
        if (dimension.fixed || f0)
            points = 1;
        const double low = to_scale(p.scale, p.lower), high = to_scale(p.scale, p.upper);
        if (p.scale == Scale::Angle && !dimension.fixed) {
            axes.push_back(angles(lobe, low, high, several));
            continue;
        }
        std::vector<double> axis;
        for (int k = 0; k < points; ++k)
            axis.push_back(points == 1 ? (f0 || dimension.fixed ? low : 0.5 * (low + high))
                                       : low + (high - low) * k / (points - 1));
        axes.push_back(axis);
    }
    return axes;
}

Search::Search(const Device& device, const GramProgram& gram_program,
               const std::vector<Objective*>& single, const Space& space,
               const std::vector<PartialFit>& partial)
    : channels_(single.front()->samples().channels), norm_(single.front()->samples().norm()) {
    rows_ = channels_ + 1;
    for (std::size_t l = 0; l < single.size(); ++l) {
        spaces_.push_back(space.of_lobe(static_cast<int>(l)));
        std::size_t twin = 0;
        while (twin < l && !(single[twin] == single[l] && same_ranges(spaces_[twin], spaces_[l])))
            ++twin;
        grid_.push_back(twin < l ? grid_[twin]
                                 : add_grid(*single[l], spaces_[l], single.size() > 1));
    }
    for (const PartialFit& fit : partial)
        given_.push_back(add_given(fit, single));
    if (single.size() == 1)
        fill_gram_of_one_lobe(*single.front());
    else
        fill_gram(device, gram_program(), single);
}

// Every point of the lobe's grid becomes a shape.
Search::Range Search::add_grid(Objective& objective, const Space& space, bool several) {
    const int begin = static_cast<int>(shapes_.size());
    const std::vector<std::vector<double>> axes = axes_of(space, several);
    constexpr std::size_t none = ~std::size_t{0};
    const std::size_t pair = has_free_angle(space) ? exchangeable(space).value_or(none) : none;
    std::vector<int> place(axes.size(), 0);
    for (bool more = true; more;) {
        Shape shape;
        for (std::size_t i = 0; i < axes.size(); ++i) {
            const Parameter& p = space.dimensions()[i].parameter;
            const double value = from_scale(p.scale, axes[i][static_cast<std::size_t>(place[i])]);
            shape.theta.push_back(std::clamp(value, p.lower, p.upper));
        }
        shape.place = place;
        // A round lobe is the same in every frame.
        if (pair == none || place[pair] != place[pair + 1] || place.back() == 0) {
            add_shape(shape, has_free_f0(space));
            objective_.push_back(&objective);
        }
        more = false;
        for (std::size_t i = 0; i < axes.size() && !more; ++i) {
            if (++place[i] < static_cast<int>(axes[i].size()))
                more = true;
            else
                place[i] = 0;
        }
    }
    return {begin, static_cast<int>(shapes_.size())};
}

// The lobes of a fit without one, as shapes off the grid.
Combination Search::add_given(const PartialFit& fit, const std::vector<Objective*>& single) {
    Combination combination{{}, std::vector<double>(single.size(), 0.0), 0};
    auto next = fit.theta.begin();
    for (std::size_t l = 0; l < single.size(); ++l) {
        if (static_cast<int>(l) == fit.missing) {
            combination.shapes.push_back(-1);
            continue;
        }
        const auto size = static_cast<std::ptrdiff_t>(spaces_[l].dimensions().size());
        Shape shape;
        shape.theta.assign(next, next + size);
        next += size;
        combination.shapes.push_back(add_shape(shape, false));
        objective_.push_back(single[l]);
    }
    return combination;
}

int Search::add_shape(Shape shape, bool mixed) {
    shape.low_row = rows_++;
    shape.high_row = mixed ? rows_++ : shape.low_row;
    shapes_.push_back(std::move(shape));
    return static_cast<int>(shapes_.size()) - 1;
}

void Search::fill_gram(const Device& device, const SharedProgram& gram_program,
                       const std::vector<Objective*>& single) {
    const DeviceSamples& samples = single.front()->samples();
    const std::size_t tiles = (static_cast<std::size_t>(rows_) + tile - 1) / tile;
    const cl::Buffer rows = make_buffer(device, tiles * tile * samples.stride * sizeof(float));
    single.front()->write_fixed_rows(rows);
    // Shapes of one objective follow each other: one batch of candidates each.
    for (std::size_t begin = 0; begin < shapes_.size();) {
        std::size_t end = begin;
        std::vector<std::vector<double>> candidates;
        while (end < shapes_.size() && objective_[end] == objective_[begin]) {
            candidates.push_back(shapes_[end].theta);
            if (shapes_[end].mixed()) {
                candidates.push_back(shapes_[end].theta);
                for (std::size_t l = 0; l < spaces_.size(); ++l)
                    if (grid_[l].begin <= static_cast<int>(end) &&
                        static_cast<int>(end) < grid_[l].end)
                        candidates.back()[0] = spaces_[l].dimensions()[0].parameter.upper;
            }
            ++end;
        }
        objective_[begin]->write_shape_rows(rows, static_cast<std::size_t>(shapes_[begin].low_row),
                                            candidates);
        begin = end;
    }
    const auto width = static_cast<std::size_t>(device.form.vector_width);
    const auto local = static_cast<std::size_t>(device.form.local_size);
    const std::size_t outputs = tiles * tiles * samples.groups * tile * tile;
    const cl::Buffer out = make_buffer(device, outputs * sizeof(float), CL_MEM_WRITE_ONLY);
    cl::Kernel kernel(gram_program.program, "gram");
    kernel.setArg(0, rows);
    kernel.setArg(1, static_cast<cl_uint>(samples.stride / width));
    kernel.setArg(2, out);
    const std::lock_guard<std::mutex> lock(gram_program.running);
    device.queue.enqueueNDRangeKernel(kernel, cl::NullRange,
                                      cl::NDRange(tiles * local, tiles, samples.groups),
                                      cl::NDRange(local, 1, 1));
    const std::vector<float> sums = download<float>(device, out, outputs);
    gram_.resize(rows_, rows_);
    for (int i = 0; i < rows_; ++i)
        for (int j = 0; j <= i; ++j) {
            const std::size_t at =
                static_cast<std::size_t>(i / tile) * tiles + static_cast<std::size_t>(j / tile);
            const auto within = static_cast<std::size_t>((i % tile) * tile + j % tile);
            double sum = 0;
            for (std::size_t g = 0; g < samples.groups; ++g)
                sum += sums[(at * samples.groups + g) * tile * tile + within];
            gram_(i, j) = gram_(j, i) = sum / norm_;
        }
}

// Combinations of one lobe need no products of two shapes: the others stay 0.
void Search::fill_gram_of_one_lobe(Objective& objective) {
    std::vector<std::vector<double>> candidates;
    for (const Shape& shape : shapes_)
        candidates.push_back(shape.theta);
    const FixedSums fixed = objective.fixed_sums();
    const std::vector<ShapeSums> sums = objective.shape_sums(candidates);
    gram_ = Eigen::MatrixXd::Zero(rows_, rows_);
    const auto set = [&](int i, int j, double value) { gram_(i, j) = gram_(j, i) = value; };
    set(channels_, channels_, fixed.bb);
    for (int ch = 0; ch < channels_; ++ch) {
        set(ch, ch, fixed.yy / channels_);
        set(ch, channels_, fixed.by[static_cast<std::size_t>(ch)]);
    }
    for (std::size_t n = 0; n < shapes_.size(); ++n) {
        const ShapeSums& s = sums[n];
        const Shape& shape = shapes_[n];
        // The row at the highest f0 is s + step t.
        const double step =
            shape.mixed() ? spaces_[0].dimensions()[0].parameter.upper - shape.theta[0] : 0;
        set(shape.low_row, shape.low_row, s.ss);
        set(shape.low_row, shape.high_row, s.ss + step * s.st);
        set(shape.high_row, shape.high_row, s.ss + step * (2 * s.st + step * s.tt));
        set(shape.low_row, channels_, s.sb);
        set(shape.high_row, channels_, s.sb + step * s.tb);
        for (int ch = 0; ch < channels_; ++ch) {
            const auto c = static_cast<std::size_t>(ch);
            set(shape.low_row, ch, s.sy[c]);
            set(shape.high_row, ch, s.sy[c] + step * s.ty[c]);
        }
    }
}

double Search::inner(const Column& a, const Column& b) const {
    if (a.low == a.high && b.low == b.high)
        return gram_(a.low, b.low);
    return (1 - a.share) * ((1 - b.share) * gram_(a.low, b.low) + b.share * gram_(a.low, b.high)) +
           a.share * ((1 - b.share) * gram_(a.high, b.low) + b.share * gram_(a.high, b.high));
}

// Squared error over all channels of the best non-negative coefficients of the columns, and the sum
// over the channels of these.
double Search::solve(const Columns& columns, SmallVector& strengths) const {
    const int n = columns.count;
    SmallMatrix gram(n, n);
    SmallVector projected(n);
    const SmallVector reference = SmallVector::Zero(n);
    strengths = reference;
    for (int i = 0; i < n; ++i)
        for (int j = 0; j <= i; ++j)
            gram(i, j) = gram(j, i) = inner(columns.at(i), columns.at(j));
    if (!gram.allFinite())
        return std::numeric_limits<double>::infinity();
    double error = 0;
    for (int ch = 0; ch < channels_; ++ch) {
        for (int i = 0; i < n; ++i)
            projected[i] = inner(columns.at(i), {ch, ch, 0});
        const NonNegativeSolution solution =
            solve_nonnegative(gram, projected, gram_(ch, ch), reference);
        error += solution.squared_error;
        strengths += solution.a;
    }
    return error;
}

// Squared error of the combination where each channel may choose the f0 of the lobes `added` (a bit
// mask): a lower bound of its error. Sets these lobes' shares to what the channels agree on best.
double Search::relaxed(Combination& combination, unsigned added) const {
    Columns columns;
    columns.add({channels_, channels_, 0});
    const std::size_t lobes = combination.shapes.size();
    for (std::size_t l = 0; l < lobes; ++l) {
        const Shape& shape = shapes_[static_cast<std::size_t>(combination.shapes[l])];
        if ((added >> l & 1U) == 0 || !shape.mixed()) {
            columns.add({shape.low_row, shape.high_row, combination.shares[l]});
        } else {
            columns.add({shape.low_row, shape.low_row, 0});
            columns.add({shape.high_row, shape.high_row, 0});
        }
    }
    SmallVector strengths;
    const double error = solve(columns, strengths);
    int column = 1;
    for (std::size_t l = 0; l < lobes; ++l, ++column) {
        if ((added >> l & 1U) == 0 ||
            !shapes_[static_cast<std::size_t>(combination.shapes[l])].mixed())
            continue;
        const double both = strengths[column] + strengths[column + 1];
        combination.shares[l] = both > 0 ? strengths[column + 1] / both : 0.5;
        ++column;
    }
    return error;
}

// Moves the shares of f0, one lobe at a time, to the best of a few; sets the error without
// relaxation.
void Search::refine(Combination& combination) const {
    const auto error = [&] { return relaxed(combination, 0); };
    combination.squared_error = error();
    for (int sweep = 0; sweep < 2; ++sweep)
        for (std::size_t l = 0; l < combination.shapes.size(); ++l) {
            if (!shapes_[static_cast<std::size_t>(combination.shapes[l])].mixed())
                continue;
            double best = combination.shares[l];
            for (const double share : {0.0, 0.02, 0.05, 0.1, 0.2, 0.4, 0.7, 1.0}) {
                combination.shares[l] = share;
                const double e = error();
                if (e < combination.squared_error) {
                    combination.squared_error = e;
                    best = share;
                }
            }
            combination.shares[l] = best;
        }
}

// The best of `count` combinations, each made by `make(i)` with the lobes `added` new to it, by
// their relaxed errors; then with f0 refined. Only the errors of all are kept.
template <typename Make>
std::vector<Combination> Search::best_of(std::size_t count, unsigned added, Make make) const {
    std::vector<double> errors(count);
    parallel_pieces(count, 64, [&](std::size_t begin, std::size_t end) {
        Combination combination;
        for (std::size_t i = begin; i < end; ++i) {
            make(i, combination);
            errors[i] = relaxed(combination, added);
        }
    });
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), std::size_t{0});
    const std::size_t kept = std::min(refined, count);
    std::partial_sort(order.begin(), order.begin() + static_cast<std::ptrdiff_t>(kept), order.end(),
                      [&](std::size_t a, std::size_t b) {
                          return errors[a] != errors[b] ? errors[a] < errors[b] : a < b;
                      });
    std::vector<Combination> best(kept);
    parallel_pieces(kept, 4, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
            make(order[i], best[i]);
            relaxed(best[i], added);
            refine(best[i]);
        }
    });
    std::stable_sort(best.begin(), best.end(), [](const Combination& a, const Combination& b) {
        return a.squared_error < b.squared_error;
    });
    return best;
}

// The best of every combination in `base` with every shape in place `lobe`, which is added or,
// where it is there already, replaced.
std::vector<Combination> Search::extended(const std::vector<Combination>& base,
                                          std::size_t lobe) const {
    const Range range = grid_[lobe];
    const auto shapes = static_cast<std::size_t>(range.end - range.begin);
    return best_of(base.size() * shapes, 1U << lobe, [&](std::size_t i, Combination& combination) {
        combination = base[i / shapes];
        combination.shapes.resize(std::max(lobe + 1, combination.shapes.size()));
        combination.shares.resize(combination.shapes.size());
        combination.shapes[lobe] = range.begin + static_cast<int>(i % shapes);
    });
}

// The best combinations of all lobes: one and two exhaustively.
std::vector<Combination> Search::best_sets() const {
    if (grid_.size() == 1)
        return extended({Combination{}}, 0);
    std::vector<std::pair<int, int>> pairs;
    const bool twins = grid_[0].begin == grid_[1].begin;
    for (int i = grid_[0].begin; i < grid_[0].end; ++i)
        for (int j = twins ? i + 1 : grid_[1].begin; j < grid_[1].end; ++j)
            pairs.emplace_back(i, j);
    std::vector<Combination> sets =
        best_of(pairs.size(), 3U, [&](std::size_t i, Combination& combination) {
            combination.shapes = {pairs[i].first, pairs[i].second};
            combination.shares = {0, 0};
        });
    for (std::size_t l = 2; l < grid_.size(); ++l) {
        sets.resize(std::min(sets.size(), beam));
        sets = extended(sets, l);
    }
    return sets;
}

bool Search::neighbours(const Combination& a, const Combination& b) const {
    for (std::size_t l = 0; l < a.shapes.size(); ++l) {
        const std::vector<int>& p = shapes_[static_cast<std::size_t>(a.shapes[l])].place;
        const std::vector<int>& q = shapes_[static_cast<std::size_t>(b.shapes[l])].place;
        for (std::size_t i = 0; i < p.size(); ++i)
            if (std::abs(p[i] - q[i]) > 1)
                return false;
    }
    return true;
}

StartingPoint Search::start_of(const Combination& combination) const {
    StartingPoint start{{}, combination.squared_error};
    for (std::size_t l = 0; l < combination.shapes.size(); ++l) {
        const Shape& shape = shapes_[static_cast<std::size_t>(combination.shapes[l])];
        std::vector<double> theta = shape.theta;
        if (shape.mixed()) {
            const Parameter& f0 = spaces_[l].dimensions()[0].parameter;
            theta[0] = f0.lower + combination.shares[l] * (f0.upper - f0.lower);
        }
        start.theta.insert(start.theta.end(), theta.begin(), theta.end());
    }
    return start;
}

std::vector<StartingPoint> Search::best(std::size_t count) const {
    std::vector<Combination> chosen;
    for (const Combination& candidate : best_sets()) {
        if (chosen.size() == count)
            break;
        const bool distinct =
            std::none_of(chosen.begin(), chosen.end(),
                         [&](const Combination& other) { return neighbours(candidate, other); });
        if (distinct && std::isfinite(candidate.squared_error))
            chosen.push_back(candidate);
    }
    for (const Combination& given : given_) {
        const auto missing = static_cast<std::size_t>(
            std::find(given.shapes.begin(), given.shapes.end(), -1) - given.shapes.begin());
        const std::vector<Combination> completed = extended({given}, missing);
        if (!completed.empty())
            chosen.push_back(completed.front());
    }
    std::vector<StartingPoint> starts;
    for (const Combination& combination : chosen)
        starts.push_back(start_of(combination));
    std::stable_sort(starts.begin(), starts.end(),
                     [](const StartingPoint& a, const StartingPoint& b) {
                         return a.squared_error < b.squared_error;
                     });
    return starts;
}

} // namespace

std::vector<StartingPoint> search_shapes(const Device& device, const GramProgram& gram_program,
                                         const std::vector<Objective*>& single, const Space& space,
                                         const std::vector<PartialFit>& partial,
                                         std::size_t count) {
    return Search(device, gram_program, single, space, partial).best(count);
}

} // namespace brdfit
