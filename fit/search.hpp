#pragma once

#include "fit/objective.hpp"
#include "fit/space.hpp"

#include <functional>
#include <vector>

namespace brdfit {

/// A starting point for the polish: theta of all lobes, and its squared error on the searched
/// samples.
struct StartingPoint {
    std::vector<double> theta;
    double squared_error;
};

/// Lobes fitted without one of them: theta of all lobes but `missing`, concatenated.
struct PartialFit {
    int missing;
    std::vector<double> theta;
};

/// Gives the program of kernels/passes/gram.cl; called where there are several lobes.
using GramProgram = std::function<const SharedProgram&()>;

/// Global search over a grid of lobe shapes on thinned samples.
///
/// For one lobe a batched pass gives each shape's products with the channels and the diffuse shape.
/// Otherwise all shapes of all lobe models become rows; one batched pass over the samples gives the
/// inner products of all pairs of rows, and with these the error of any combination of shapes is
/// small linear algebra. A Fresnel lobe between the lowest and the highest f0 is a non-negative
/// mixture of two rows, so f0 needs no grid. One and two lobes are searched exhaustively, further
/// lobes are added to the best combinations so far; each of `partial` is completed by the best
/// missing lobe, so that a fit is never worse than the one it extends.
///
/// `single` has, for each lobe of the structure, an objective on the thinned samples whose
/// structure is the diffuse shape and that lobe alone; lobes of one model share one. Returns at
/// most `count` points, no two of them neighbours on the grid, best first, and one for each of
/// `partial`.
std::vector<StartingPoint> search_shapes(const Device& device, const GramProgram& gram_program,
                                         const std::vector<Objective*>& single, const Space& space,
                                         const std::vector<PartialFit>& partial, std::size_t count);

} // namespace brdfit
