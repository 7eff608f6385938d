// The numerical parts below a fit: NLopt behind minimise(), and exact non-negative least squares.

#include "fit/minimise.hpp"
#include "fit/nonnegative.hpp"
#include "host/error.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <nlopt.h>
#include <random>
#include <stdexcept>

namespace brdfit {

namespace {

using Point = std::vector<double>;

const Point centre{0.3, -1.2, 2.0}, low{-2, -3, -1}, high{4, 1.5, 5}, far_start{3, 1, 4.5};

double quadratic_bowl(const Point& x, Point* gradient) {
    double value = 0.5;
    if (gradient != nullptr)
        gradient->assign(x.size(), 0);
    for (std::size_t i = 0; i < x.size(); ++i) {
        const double weight = 1 + static_cast<double>(i);
        value += weight * (x[i] - centre[i]) * (x[i] - centre[i]);
        if (gradient != nullptr)
            (*gradient)[i] = 2 * weight * (x[i] - centre[i]);
    }
    return value;
}

/// Every algorithm that algorithm_named accepts.
std::vector<std::string> algorithms() {
    std::vector<std::string> names;
    for (int i = 0; i < NLOPT_NUM_ALGORITHMS; ++i) {
        const std::string name = nlopt_algorithm_to_string(static_cast<nlopt_algorithm>(i));
        try {
            names.push_back(algorithm_named(name));
        } catch (const UsageError&) {
        }
    }
    return names;
}

/// A function with a record of what it was asked.
struct Recorded {
    Function function;
    Point best;
    double best_value = std::numeric_limits<double>::infinity();
    int calls = 0;
    bool in_box = true;

    Function recording() {
        return [this](const Point& x, Point* gradient) {
            const double value = function(x, gradient);
            ++calls;
            for (std::size_t i = 0; i < x.size(); ++i)
                in_box = in_box && x[i] >= low[i] && x[i] <= high[i];
            if (value < best_value) {
                best_value = value;
                best = x;
            }
            return value;
        };
    }
};

class EveryAlgorithm : public testing::TestWithParam<std::string> {
  protected:
    MinimiseOptions options() const {
        MinimiseOptions options;
        options.algorithm = GetParam();
        options.max_evaluations = 50;
        return options;
    }
};

INSTANTIATE_TEST_SUITE_P(Minimise, EveryAlgorithm, testing::ValuesIn(algorithms()),
                         [](const auto& info) { return info.param; });

TEST_P(EveryAlgorithm, returns_the_best_point_it_saw_within_the_box) {
    Recorded recorded{quadratic_bowl, {}, std::numeric_limits<double>::infinity()};
    const Minimum minimum = minimise(recorded.recording(), far_start, low, high, options());
    EXPECT_EQ(minimum.value, recorded.best_value);
    EXPECT_EQ(minimum.x, recorded.best);
    EXPECT_EQ(minimum.evaluations, recorded.calls);
    EXPECT_EQ(quadratic_bowl(minimum.x, nullptr), minimum.value);
    EXPECT_LT(minimum.value, quadratic_bowl(far_start, nullptr));
    EXPECT_TRUE(recorded.in_box);
}

TEST_P(EveryAlgorithm, stays_at_the_optimum_when_it_starts_there) {
    const Minimum minimum = minimise(quadratic_bowl, centre, low, high, options());
    EXPECT_EQ(minimum.x, centre);
    EXPECT_EQ(minimum.value, 0.5);
}

TEST_P(EveryAlgorithm, survives_values_that_are_not_finite_in_a_part_of_the_box) {
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(),
          -std::numeric_limits<double>::infinity()}) {
        const Function function = [&](const Point& x, Point* gradient) {
            const double value = quadratic_bowl(x, gradient);
            if (x[0] < 0.25) { // right beside the optimum
                if (gradient != nullptr)
                    gradient->assign(x.size(), bad);
                return bad;
            }
            return value;
        };
        const Minimum minimum = minimise(function, far_start, low, high, options());
        ASSERT_TRUE(std::isfinite(minimum.value)) << bad;
        EXPECT_EQ(quadratic_bowl(minimum.x, nullptr), minimum.value) << bad;
        EXPECT_GE(minimum.x[0], 0.25) << bad;
        EXPECT_LE(minimum.value, quadratic_bowl(far_start, nullptr)) << bad;
    }
}

TEST_P(EveryAlgorithm, lets_an_exception_of_the_function_out) {
    int calls = 0;
    const Function function = [&](const Point& x, Point* gradient) {
        if (++calls == 3)
            throw std::runtime_error("the third call");
        return quadratic_bowl(x, gradient);
    };
    try {
        minimise(function, far_start, low, high, options());
        FAIL() << "the exception was swallowed";
    } catch (const std::runtime_error& error) {
        EXPECT_STREQ(error.what(), "the third call");
        EXPECT_EQ(calls, 3);
    }
}

TEST_P(EveryAlgorithm, gives_the_same_answer_every_time) {
    const Minimum first = minimise(quadratic_bowl, far_start, low, high, options());
    const Minimum second = minimise(quadratic_bowl, far_start, low, high, options());
    EXPECT_EQ(first.x, second.x);
    EXPECT_EQ(first.evaluations, second.evaluations);
}

TEST(Minimise, default_finds_the_optimum) {
    const Minimum minimum = minimise(quadratic_bowl, far_start, low, high, {});
    for (std::size_t i = 0; i < centre.size(); ++i)
        EXPECT_NEAR(minimum.x[i], centre[i], 1e-4);
}

TEST(Minimise, default_finds_an_optimum_on_the_bounds) {
    const Minimum minimum = minimise(quadratic_bowl, {2, 1, 4}, {1, -3, 2.5}, high, {});
    EXPECT_NEAR(minimum.x[0], 1, 1e-6);
    EXPECT_NEAR(minimum.x[1], centre[1], 1e-4);
    EXPECT_NEAR(minimum.x[2], 2.5, 1e-6);
}

TEST(Minimise, value_is_infinite_where_nothing_is_finite) {
    const Function function = [](const Point& x, Point* gradient) {
        if (gradient != nullptr)
            gradient->assign(x.size(), 1);
        return std::numeric_limits<double>::quiet_NaN();
    };
    EXPECT_TRUE(std::isinf(minimise(function, far_start, low, high, {}).value));
    EXPECT_TRUE(std::isinf(minimise(function, {}, {}, {}, {}).value));
}

TEST(Minimise, leaves_a_start_whose_value_is_not_finite) {
    const Function function = [](const Point& x, Point* gradient) {
        const double value = quadratic_bowl(x, gradient);
        return x == far_start ? std::numeric_limits<double>::quiet_NaN() : value;
    };
    MinimiseOptions options;
    options.algorithm = algorithm_named("bobyqa");
    const Minimum minimum = minimise(function, far_start, low, high, options);
    EXPECT_NEAR(minimum.value, 0.5, 1e-3);
}

TEST(Minimise, without_unknowns_asks_once) {
    int calls = 0;
    const Function function = [&](const Point&, Point*) {
        ++calls;
        return 7.0;
    };
    const Minimum minimum = minimise(function, {}, {}, {}, {});
    EXPECT_EQ(minimum.value, 7);
    EXPECT_EQ(minimum.evaluations, 1);
    EXPECT_EQ(calls, 1);
}

TEST(Minimise, never_asks_much_more_often_than_allowed) {
    for (const int most : {1, 5, 40}) {
        MinimiseOptions options;
        options.max_evaluations = most;
        // A narrow valley, so that it does not end by itself.
        const Function valley = [](const Point& x, Point* gradient) {
            const double a = x[1] - x[0] * x[0], b = 1 - x[0];
            if (gradient != nullptr)
                *gradient = {-400 * x[0] * a - 2 * b, 200 * a, 0};
            return 100 * a * a + b * b;
        };
        EXPECT_LE(minimise(valley, {-2, -3, 0}, low, high, options).evaluations, most + 1) << most;
    }
}

TEST(AlgorithmNamed, takes_nlopts_names_in_any_case_and_without_the_first_letters) {
    for (const char* name : {"LD_SLSQP", "ld_slsqp", "slsqp", "SLSQP", "ld-slsqp"})
        EXPECT_EQ(algorithm_named(name), "LD_SLSQP") << name;
    EXPECT_EQ(algorithm_named("bobyqa"), "LN_BOBYQA");
    EXPECT_EQ(algorithm_named("neldermead"), "LN_NELDERMEAD");
}

TEST(AlgorithmNamed, refuses_unknown_names_and_lists_the_known) {
    for (const char* name : {"", "no such", "SLSQP2", "LN_SLSQP", "_SLSQP", "G_MLSL", "auglag"})
        try {
            algorithm_named(name);
            ADD_FAILURE() << "accepted '" << name << "'";
        } catch (const UsageError& error) {
            EXPECT_NE(std::string(error.what()).find("slsqp"), std::string::npos) << error.what();
        }
}

// Non-negative least squares.

struct Problem {
    Eigen::MatrixXd columns; ///< B
    Eigen::VectorXd y;

    double squared_error(const Eigen::VectorXd& a) const { return (y - columns * a).squaredNorm(); }
    NonNegativeSolution solve(const Eigen::VectorXd& reference) const {
        const Eigen::VectorXd residual = y - columns * reference;
        return solve_nonnegative(columns.transpose() * columns, columns.transpose() * residual,
                                 residual.squaredNorm(), reference);
    }
};

Problem random_problem(std::mt19937_64& random, int unknowns, int rows = 12) {
    std::normal_distribution<double> normal;
    Problem problem{Eigen::MatrixXd(rows, unknowns), Eigen::VectorXd(rows)};
    // Lengths as different as a diffuse shape's and a mirror's.
    for (int j = 0; j < unknowns; ++j) {
        const double length = std::exp(2 * normal(random));
        for (int i = 0; i < rows; ++i)
            problem.columns(i, j) = length * normal(random);
    }
    for (int i = 0; i < rows; ++i)
        problem.y[i] = normal(random);
    return problem;
}

/// The least squared error over all subsets of columns whose own least-squares solution is
/// non-negative, by a decomposition that does not mind singular ones.
double brute_force(const Problem& problem) {
    const int n = static_cast<int>(problem.columns.cols());
    double best = problem.y.squaredNorm();
    for (unsigned subset = 1; subset < 1U << n; ++subset) {
        Eigen::MatrixXd columns(problem.columns.rows(), 0);
        for (int j = 0; j < n; ++j)
            if ((subset >> j & 1U) != 0) {
                columns.conservativeResize(Eigen::NoChange, columns.cols() + 1);
                columns.col(columns.cols() - 1) = problem.columns.col(j);
            }
        const Eigen::VectorXd a = columns.completeOrthogonalDecomposition().solve(problem.y);
        if ((a.array() >= -1e-12).all())
            best = std::min(best, (problem.y - columns * a).squaredNorm());
    }
    return best;
}

/// Karush-Kuhn-Tucker: no unknown is negative; the error falls towards none that is 0, and is flat
/// along the others.
void expect_optimal(const Problem& problem, const NonNegativeSolution& solution,
                    double tolerance = 1e-9) {
    const Eigen::VectorXd a = solution.a;
    const Eigen::VectorXd slope =
        -2 * problem.columns.transpose() * (problem.y - problem.columns * a);
    for (Eigen::Index j = 0; j < a.size(); ++j) {
        const double unit = problem.columns.col(j).norm() * problem.y.norm() + 1e-300;
        EXPECT_GE(a[j], 0);
        EXPECT_GE(slope[j] / unit, -tolerance);
        EXPECT_TRUE(a[j] == 0 || slope[j] / unit <= tolerance);
    }
    const double scale = problem.y.squaredNorm();
    EXPECT_NEAR(solution.squared_error, problem.squared_error(a), tolerance * scale);
    EXPECT_NEAR(solution.squared_error, brute_force(problem), tolerance * scale);
}

TEST(SolveNonnegative, meets_the_conditions_of_an_optimum_on_random_problems) {
    std::mt19937_64 random(1);
    for (int unknowns = 1; unknowns <= max_unknowns; ++unknowns)
        for (int i = 0; i < 100; ++i) {
            const Problem problem = random_problem(random, unknowns);
            expect_optimal(problem, problem.solve(Eigen::VectorXd::Zero(unknowns)));
        }
}

TEST(SolveNonnegative, answer_does_not_depend_on_the_reference) {
    std::mt19937_64 random(2);
    std::uniform_real_distribution<double> uniform(0, 3);
    for (int i = 0; i < 200; ++i) {
        const int unknowns = 1 + i % max_unknowns;
        const Problem problem = random_problem(random, unknowns);
        Eigen::VectorXd reference(unknowns);
        for (double& r : reference)
            r = uniform(random) < 1 ? 0 : uniform(random) / 3;
        expect_optimal(problem, problem.solve(reference));
    }
}

TEST(SolveNonnegative, finds_the_coefficients_that_made_the_data) {
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> uniform(0.1, 2);
    for (int unknowns = 1; unknowns <= max_unknowns; ++unknowns) {
        Problem problem = random_problem(random, unknowns);
        Eigen::VectorXd truth(unknowns);
        for (double& t : truth)
            t = uniform(random);
        truth[unknowns / 2] = 0;
        problem.y = problem.columns * truth;
        const NonNegativeSolution solution = problem.solve(Eigen::VectorXd::Zero(unknowns));
        for (int j = 0; j < unknowns; ++j)
            EXPECT_NEAR(solution.a[j], truth[j], 1e-9);
    }
}

TEST(SolveNonnegative, copes_with_columns_that_explain_each_other) {
    std::mt19937_64 random(4);
    for (int i = 0; i < 200; ++i) {
        const int unknowns = 2 + i % (max_unknowns - 1);
        Problem problem = random_problem(random, unknowns);
        switch (i % 4) {
        case 0: // one twice
            problem.columns.col(1) = 3 * problem.columns.col(0);
            break;
        case 1: // one that is the sum of others
            problem.columns.col(0) = problem.columns.rightCols(unknowns - 1).rowwise().sum();
            break;
        case 2: // one that vanishes
            problem.columns.col(unknowns - 1).setZero();
            break;
        default: // fewer samples than unknowns
            problem = random_problem(random, unknowns, 2);
        }
        expect_optimal(problem, problem.solve(Eigen::VectorXd::Zero(unknowns)), 1e-6);
    }
}

TEST(SolveNonnegative, is_zero_where_every_column_vanishes) {
    for (int unknowns = 1; unknowns <= max_unknowns; ++unknowns) {
        const SmallVector zero = SmallVector::Zero(unknowns);
        const NonNegativeSolution solution =
            solve_nonnegative(SmallMatrix::Zero(unknowns, unknowns), zero, 2.5, zero);
        EXPECT_EQ(solution.a, zero);
        EXPECT_EQ(solution.squared_error, 2.5);
    }
}

TEST(SolveNonnegative, error_is_not_finite_where_the_sums_are_not) {
    for (const double bad :
         {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
        SmallMatrix gram = SmallMatrix::Identity(2, 2);
        gram(1, 1) = bad;
        const SmallVector zero = SmallVector::Zero(2);
        EXPECT_FALSE(
            std::isfinite(solve_nonnegative(gram, SmallVector::Ones(2), 1, zero).squared_error));
    }
}

// The same with limits * a <= 1.

TEST(SolveLimited, is_optimal_by_its_multipliers) {
    std::mt19937_64 random(11);
    int limited = 0;
    for (int trial = 0; trial < 2000; ++trial) {
        const int unknowns = 1 + trial % max_unknowns, rows = 1 + trial % 13;
        const Problem problem = random_problem(random, unknowns);
        Eigen::MatrixXd limits(rows, unknowns);
        std::exponential_distribution<double> positive(0.3);
        for (Eigen::Index i = 0; i < limits.size(); ++i)
            limits.data()[i] = trial % 5 == 0 && i % 4 == 0 ? 0 : positive(random);
        const Eigen::VectorXd reference = Eigen::VectorXd::Constant(unknowns, 0.1 * (trial % 3));
        const Eigen::MatrixXd gram = problem.columns.transpose() * problem.columns;
        const Eigen::VectorXd residual = problem.y - problem.columns * reference;
        const LimitedSolution solution = solve_limited(gram, problem.columns.transpose() * residual,
                                                       residual.squaredNorm(), reference, limits);
        const Eigen::VectorXd a = solution.a;
        EXPECT_NEAR(solution.squared_error, problem.squared_error(a), 1e-9);
        EXPECT_GE(a.minCoeff(), 0);
        EXPECT_GE(solution.multipliers.minCoeff(), 0);
        const Eigen::VectorXd r = limits * a;
        EXPECT_LE(r.maxCoeff(), 1 + 1e-9);
        limited += solution.multipliers.maxCoeff() > 0 ? 1 : 0;
        // What pulls at an unknown is held by its bound or by the limits that bind (Kuhn, Tucker).
        const Eigen::VectorXd pull =
            2 * problem.columns.transpose() * (problem.y - problem.columns * a) -
            limits.transpose() * solution.multipliers;
        for (int j = 0; j < unknowns; ++j) {
            const double tolerance = 1e-6 * std::sqrt(gram(j, j)) * problem.y.norm();
            EXPECT_LE(pull[j], tolerance) << trial;
            if (a[j] > 0) {
                EXPECT_GE(pull[j], -tolerance) << trial;
            }
        }
        for (Eigen::Index k = 0; k < rows; ++k)
            if (solution.multipliers[k] > 1e-9) {
                EXPECT_NEAR(r[k], 1, 1e-9) << trial;
            }
    }
    EXPECT_GT(limited, 500); // else nothing was tried
}

TEST(SolveLimited, leaves_out_what_is_infinite_and_takes_what_is_alike) {
    std::mt19937_64 random(12);
    for (int unknowns = 2; unknowns <= max_unknowns; ++unknowns) {
        Problem problem = random_problem(random, unknowns);
        problem.columns = problem.columns.cwiseAbs();
        problem.y = 3 * problem.columns.rowwise().sum();
        problem.columns.col(1) = problem.columns.col(0); // singular
        Eigen::MatrixXd limits = Eigen::MatrixXd::Constant(3, unknowns, 0.5);
        const auto solved = [&] {
            return solve_limited(problem.columns.transpose() * problem.columns,
                                 problem.columns.transpose() * problem.y, problem.y.squaredNorm(),
                                 SmallVector::Zero(unknowns), limits);
        };
        EXPECT_NEAR(solved().a.sum(), 2, 1e-6);
        limits(1, 0) = std::numeric_limits<double>::infinity();
        const LimitedSolution solution = solved();
        EXPECT_EQ(solution.a[0], 0);
        EXPECT_NEAR(solution.a.sum(), 2, 1e-6);
    }
}

} // namespace

} // namespace brdfit
