#pragma once

#include "host/directions.hpp"
#include "host/evaluate/evaluate.hpp"

#include <cstddef>
#include <nanobind/nanobind.h>
#include <nanobind/ndarray.h>
#include <string>
#include <vector>

// Arrays that cross the border: rows of float32 or float64 in, planes of float32 out.

namespace brdfit::python {

namespace nb = nanobind;

/// A two-dimensional array of float32 or float64 with any strides. Keeps it alive, not the
/// interpreter's lock.
class Rows {
  public:
    /// Throws InputError, naming it, for what is no such array. `columns` 0: any number.
    Rows(nb::handle array, std::string name, std::size_t columns);

    std::size_t count() const { return count_; }
    std::size_t columns() const { return columns_; }
    const std::string& name() const { return name_; }
    double at(std::size_t row, std::size_t column) const {
        const std::ptrdiff_t i = static_cast<std::ptrdiff_t>(row) * row_stride_ +
                                 static_cast<std::ptrdiff_t>(column) * column_stride_;
        return float64_ ? static_cast<const double*>(data_)[i]
                        : static_cast<double>(static_cast<const float*>(data_)[i]);
    }

  private:
    nb::ndarray<nb::ro, nb::device::cpu> array_;
    std::string name_;
    const void* data_;
    bool float64_;
    std::size_t count_, columns_;
    std::ptrdiff_t row_stride_, column_stride_;
};

/// A shape, of which row k of some Rows is an element, for messages.
using Shape = std::vector<std::size_t>;

/// The unit vector in a row. Throws InputError naming array and element unless its length is within
/// 1e-3 of 1.
Vector unit_vector(const Rows& rows, std::size_t row, const Shape& shape);
/// Pairs of them, row by row, as read_directions makes them of a file.
Directions directions_of(const Rows& wi, const Rows& wo, const Shape& shape);
/// Makes those pairs some at a time; the arguments must outlive it.
MakePairs pairs_of(const Rows& wi, const Rows& wo, const Shape& shape);
/// Viewers of them, as read_viewers; throws also for one that is not above the horizon.
std::vector<Vector> viewers_of(const Rows& wo, const Shape& shape);

/// NumPy arrays that hold values.
using FloatArray = nb::ndarray<nb::numpy, float>;
using DoubleArray = nb::ndarray<nb::numpy, double>;

/// An array of that shape that takes the values over.
FloatArray to_array(std::vector<float>&& values, const Shape& shape);
DoubleArray to_array(std::vector<double>&& values, const Shape& shape);
/// An array of the planes, each of that shape, one after the other.
DoubleArray to_array(const std::vector<std::vector<double>>& planes, const Shape& shape);
/// A read-only NumPy array of values that `owner` keeps.
template <typename T, typename Owner>
nb::ndarray<nb::numpy, const T> view_of(const T* values, const Shape& shape, const Owner& owner) {
    const nb::capsule keeper(new Owner(owner),
                             [](void* kept) noexcept { delete static_cast<Owner*>(kept); });
    return {values, shape.size(), shape.data(), keeper};
}

} // namespace brdfit::python
