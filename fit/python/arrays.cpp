#include "fit/python/arrays.hpp"

#include "host/error.hpp"
#include "host/files/directions.hpp"
#include "host/parallel.hpp"

#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>

namespace brdfit::python {

namespace {

constexpr std::size_t piece = 1 << 14;

// "wi[2, 5]"
std::string element(const Rows& rows, std::size_t row, const Shape& shape) {
    Shape index(shape.size());
    for (std::size_t d = shape.size(); d-- > 0;) {
        index[d] = row % shape[d];
        row /= shape[d];
    }
    return index.empty() ? rows.name() : fmt::format("{}[{}]", rows.name(), fmt::join(index, ", "));
}

template <typename T>
nb::ndarray<nb::numpy, T> owned(std::vector<T>&& values, const Shape& shape) {
    auto* const kept = new std::vector<T>(std::move(values));
    const nb::capsule owner(
        kept, [](void* vector) noexcept { delete static_cast<std::vector<T>*>(vector); });
    return {kept->data(), shape.size(), shape.data(), owner};
}

} // namespace

Rows::Rows(nb::handle array, std::string name, std::size_t columns)
    : name_(std::move(name)), data_(nullptr), float64_(false), count_(0), columns_(columns),
      row_stride_(0), column_stride_(0) {
    if (!nb::try_cast(array, array_))
        throw InputError(fmt::format("{}: no array on the host", name_));
    data_ = array_.data();
    float64_ = array_.dtype() == nb::dtype<double>();
    if (!float64_ && array_.dtype() != nb::dtype<float>())
        throw InputError(fmt::format("{}: expected float32 or float64", name_));
    if (array_.ndim() != 2 || (columns > 0 && array_.shape(1) != columns))
        throw InputError(fmt::format("{}: expected shape (N, {})", name_,
                                     columns > 0 ? fmt::format("{}", columns) : "columns"));
    count_ = array_.shape(0);
    columns_ = array_.shape(1);
    row_stride_ = array_.stride(0);
    column_stride_ = array_.stride(1);
}

Vector unit_vector(const Rows& rows, std::size_t row, const Shape& shape) {
    const Vector given{rows.at(row, 0), rows.at(row, 1), rows.at(row, 2)};
    Vector unit;
    if (!normalise(given.data(), unit))
        throw InputError(fmt::format(
            "{} is ({:.6g}, {:.6g}, {:.6g}); expected a unit vector, its length within 1e-3 of 1",
            element(rows, row, shape), given[0], given[1], given[2]));
    return unit;
}

Directions directions_of(const Rows& wi, const Rows& wo, const Shape& shape) {
    Directions directions = Directions::unfilled(wi.count());
    pairs_of(wi, wo, shape)(0, wi.count(), directions);
    return directions;
}

MakePairs pairs_of(const Rows& wi, const Rows& wo, const Shape& shape) {
    return [&](std::size_t first, std::size_t count, Directions& into) {
        parallel_pieces(count, piece, [&](std::size_t begin, std::size_t end) {
            for (std::size_t k = begin; k < end; ++k)
                into.set(k, unit_vector(wi, first + k, shape), unit_vector(wo, first + k, shape));
        });
    };
}

std::vector<Vector> viewers_of(const Rows& wo, const Shape& shape) {
    std::vector<Vector> viewers;
    viewers.reserve(wo.count());
    for (std::size_t k = 0; k < wo.count(); ++k) {
        viewers.push_back(unit_vector(wo, k, shape));
        if (!(static_cast<float>(viewers.back()[2]) > 0))
            throw InputError(fmt::format("{} is not above the horizon; expected z above 0",
                                         element(wo, k, shape)));
    }
    return viewers;
}

FloatArray to_array(std::vector<float>&& values, const Shape& shape) {
    return owned(std::move(values), shape);
}

DoubleArray to_array(std::vector<double>&& values, const Shape& shape) {
    return owned(std::move(values), shape);
}

DoubleArray to_array(const std::vector<std::vector<double>>& planes, const Shape& shape) {
    std::vector<double> all;
    for (const std::vector<double>& plane : planes)
        all.insert(all.end(), plane.begin(), plane.end());
    Shape whole{planes.size()};
    whole.insert(whole.end(), shape.begin(), shape.end());
    return owned(std::move(all), whole);
}

} // namespace brdfit::python
