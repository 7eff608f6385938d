#include "fit/gauss_newton.hpp"

namespace brdfit {

GaussNewton gauss_newton(const NormalSums& sums, const StructureLayout& layout,
                         const Coefficients& a) {
    const std::vector<DerivativeEntry>& entries = layout.entries;
    const auto parameters = static_cast<Eigen::Index>(layout.parameters.size());
    GaussNewton result{Eigen::MatrixXd::Zero(parameters, parameters), sums.basis, {}};
    for (std::size_t e = 0; e < entries.size(); ++e)
        for (std::size_t f = 0; f < entries.size(); ++f)
            result.theta(entries[e].parameter, entries[f].parameter) +=
                a.col(entries[e].basis).dot(a.col(entries[f].basis)) *
                sums.entry_entry(static_cast<Eigen::Index>(e), static_cast<Eigen::Index>(f));
    for (Eigen::Index ch = 0; ch < a.rows(); ++ch) {
        result.cross.emplace_back(Eigen::MatrixXd::Zero(parameters, a.cols()));
        for (std::size_t e = 0; e < entries.size(); ++e)
            result.cross.back().row(entries[e].parameter) +=
                a(ch, entries[e].basis) * sums.entry_basis.row(static_cast<Eigen::Index>(e));
    }
    return result;
}

Eigen::MatrixXd projected(const GaussNewton& sums, const Coefficients& a) {
    Eigen::MatrixXd curvature = sums.theta;
    if (curvature.size() == 0) // no lobe; Eigen would refer to what an empty matrix has not
        return curvature;
    for (Eigen::Index ch = 0; ch < a.rows(); ++ch) {
        std::vector<Eigen::Index> used;
        for (Eigen::Index j = 0; j < a.cols(); ++j)
            if (a(ch, j) > 0)
                used.push_back(j);
        const auto m = static_cast<Eigen::Index>(used.size());
        if (m == 0)
            continue;
        Eigen::MatrixXd basis(m, m), cross(curvature.rows(), m);
        for (Eigen::Index j = 0; j < m; ++j) {
            const Eigen::Index of = used[static_cast<std::size_t>(j)];
            cross.col(j) = sums.cross[static_cast<std::size_t>(ch)].col(of);
            for (Eigen::Index k = 0; k < m; ++k)
                basis(j, k) = sums.basis(of, used[static_cast<std::size_t>(k)]);
        }
        curvature -= cross * basis.ldlt().solve(cross.transpose());
    }
    curvature.diagonal() += undetermined * sums.theta.diagonal();
    return 0.5 * (curvature + curvature.transpose());
}

} // namespace brdfit
