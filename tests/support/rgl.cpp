#include "tests/support/rgl.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numeric>
#include <random>
#include <stdexcept>

namespace brdfit::test {

namespace {

template <typename Number>
void put(std::string& bytes, Number value) {
    bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

template <typename Number>
Number get(const std::string& bytes, std::size_t& at) {
    Number value;
    std::memcpy(&value, bytes.data() + at, sizeof value);
    at += sizeof value;
    return value;
}

const TensorField* find(const std::vector<TensorField>& fields, const std::string& name) {
    const auto found = std::find_if(fields.begin(), fields.end(),
                                    [&](const TensorField& field) { return field.name == name; });
    return found == fields.end() ? nullptr : &*found;
}

/// A function on the unit square, bilinear between nodes at its edges.
struct Square {
    const float* values;
    std::size_t width, height;

    double at(std::size_t x, std::size_t y) const { return values[y * width + x]; }
    /// Along row y, integrated from 0 to u, in units of the square.
    double along(std::size_t y, double u) const {
        double sum = 0;
        for (std::size_t x = 0; x + 1 < width; ++x) {
            const double s = std::min(
                std::max(u * static_cast<double>(width - 1) - static_cast<double>(x), 0.0), 1.0);
            sum += s * at(x, y) + s * s / 2 * (at(x + 1, y) - at(x, y));
        }
        return sum / static_cast<double>(width - 1);
    }
    /// The integral over u from 0 to `u` at v.
    double across(double u, double v) const {
        const double y = v * static_cast<double>(height - 1);
        const auto row = std::min(static_cast<std::size_t>(y), height - 2);
        const double t = y - static_cast<double>(row);
        return (1 - t) * along(row, u) + t * along(row + 1, u);
    }
    /// The integral over all u and over v from 0 to `v`.
    double below(double v) const {
        double sum = 0;
        for (std::size_t y = 0; y + 1 < height; ++y) {
            const double t = std::min(
                std::max(v * static_cast<double>(height - 1) - static_cast<double>(y), 0.0), 1.0);
            sum += t * along(y, 1) + t * t / 2 * (along(y + 1, 1) - along(y, 1));
        }
        return sum / static_cast<double>(height - 1);
    }
    double value(double u, double v) const {
        const double x = u * static_cast<double>(width - 1);
        const double y = v * static_cast<double>(height - 1);
        const auto column = std::min(static_cast<std::size_t>(x), width - 2);
        const auto row = std::min(static_cast<std::size_t>(y), height - 2);
        const double s = x - static_cast<double>(column), t = y - static_cast<double>(row);
        return (1 - t) * ((1 - s) * at(column, row) + s * at(column + 1, row)) +
               t * ((1 - s) * at(column, row + 1) + s * at(column + 1, row + 1));
    }
};

/// The last two axes of a field, at one place of the others.
Square square_of(const TensorField& field, std::size_t outer = 0) {
    const std::size_t height = field.shape[field.shape.size() - 2], width = field.shape.back();
    return {field.values.data() + outer * width * height, width, height};
}

/// Shares of the nodes around x; beyond the ends the end's.
std::vector<double> shares(const std::vector<float>& nodes, double x) {
    std::vector<double> share(nodes.size());
    if (x <= nodes.front())
        share.front() = 1;
    else if (x >= nodes.back())
        share.back() = 1;
    for (std::size_t i = 0; i + 1 < nodes.size(); ++i)
        if (x > nodes[i] && x < nodes[i + 1]) {
            share[i + 1] = (x - nodes[i]) / (static_cast<double>(nodes[i + 1]) - nodes[i]);
            share[i] = 1 - share[i + 1];
        }
    return share;
}

} // namespace

std::size_t TensorField::count() const {
    return std::accumulate(shape.begin(), shape.end(), std::size_t{1}, std::multiplies<>());
}

std::string tensor_bytes(const std::vector<TensorField>& fields) {
    std::string bytes("tensor_file\0\1\0", 14);
    put(bytes, static_cast<std::uint32_t>(fields.size()));
    std::size_t end = bytes.size();
    for (const TensorField& field : fields)
        end += 2 + field.name.size() + 2 + 1 + 8 + 8 * field.shape.size();
    std::string data;
    for (const TensorField& field : fields) {
        while ((end + data.size()) % 8 != 0)
            data += '\0';
        put(bytes, static_cast<std::uint16_t>(field.name.size()));
        bytes += field.name;
        put(bytes, static_cast<std::uint16_t>(field.shape.size()));
        put(bytes, static_cast<std::uint8_t>(field.type));
        put(bytes, static_cast<std::uint64_t>(end + data.size()));
        for (const std::uint64_t n : field.shape)
            put(bytes, n);
        for (const float value : field.values)
            if (field.type == 1)
                data += static_cast<char>(value);
            else
                put(data, value);
    }
    return bytes + data;
}

std::vector<TensorField> rgl_fields(std::size_t phis, double turn, std::size_t channels) {
    std::mt19937 random(phis * 16 + channels);
    const auto values = [&](std::size_t n, float least) {
        std::vector<float> made(n);
        for (float& x : made)
            x = least + std::uniform_real_distribution<float>()(random);
        return made;
    };
    const std::size_t thetas = 4, n = 5;
    std::vector<TensorField> fields;
    const auto add = [&](const char* name, std::vector<std::uint64_t> shape, float least) {
        fields.push_back({name, 10, std::move(shape), {}});
        fields.back().values = values(fields.back().count(), least);
    };
    fields.push_back({"description", 1, {4}, {'t', 'e', 's', 't'}});
    add("phi_i", {phis}, 0);
    for (std::size_t i = 0; i < phis; ++i)
        fields.back().values[i] = phis == 1
                                      ? 0.0F
                                      : static_cast<float>(-pi + turn * static_cast<double>(i) /
                                                                     static_cast<double>(phis - 1));
    fields.push_back({"theta_i", 10, {thetas}, {0, 0.5F, 1, 1.5F}});
    add("sigma", {2, 6}, 0.2F);
    add("ndf", {3, 7}, 0.5F);
    add("vndf", {phis, thetas, 6, 9}, 0.01F);
    add("luminance", {phis, thetas, n, n}, 0);
    if (channels == 3) {
        add("rgb", {phis, thetas, 3, n, n}, -0.1F);
    } else {
        add("spectra", {phis, thetas, channels, n, n}, -0.1F);
        fields.push_back({"wavelengths", 10, {channels}, {}});
        for (std::size_t i = 0; i < channels; ++i)
            fields.back().values.push_back(400.5F + 10 * static_cast<float>(i));
    }
    fields.push_back({"jacobian", 1, {1}, {1}});
    return fields;
}

TensorField& field_of(std::vector<TensorField>& fields, const std::string& name) {
    return const_cast<TensorField&>(*find(fields, name));
}

std::vector<TensorField> read_fields(const std::string& bytes) {
    std::size_t at = 14;
    std::vector<TensorField> fields(get<std::uint32_t>(bytes, at));
    for (TensorField& field : fields) {
        const auto length = get<std::uint16_t>(bytes, at);
        field.name = bytes.substr(at, length);
        at += length;
        field.shape.resize(get<std::uint16_t>(bytes, at));
        field.type = get<std::uint8_t>(bytes, at);
        std::size_t data = get<std::uint64_t>(bytes, at);
        for (std::uint64_t& n : field.shape)
            n = get<std::uint64_t>(bytes, at);
        for (std::size_t i = 0; i < field.count(); ++i)
            if (field.type == 1)
                field.values.push_back(get<std::uint8_t>(bytes, data));
            else if (field.type == 10)
                field.values.push_back(get<float>(bytes, data));
    }
    return fields;
}

std::vector<double> rgl_reference(const std::vector<TensorField>& fields, Vector wi, Vector wo) {
    const TensorField &phis = *find(fields, "phi_i"), &thetas = *find(fields, "theta_i");
    const TensorField* const rgb = find(fields, "rgb");
    const TensorField& table = rgb != nullptr ? *rgb : *find(fields, "spectra");
    const TensorField& vndf = *find(fields, "vndf");
    const bool isotropic = phis.values.size() <= 2;
    if (!isotropic) {
        // Half of the circle: the other is its point reflection; a quarter: mirrored twice.
        const double turns = 2 * pi / (phis.values.back() - phis.values.front());
        const double y = wi[1] > 0 && turns > 1.5 ? -1 : 1;
        const double x = turns > 3 ? (wi[0] > 0 ? -1 : 1) : y;
        for (Vector* v : {&wi, &wo})
            *v = {x * (*v)[0], y * (*v)[1], (*v)[2]};
        if (turns > 1.5)
            wi[1] = -std::abs(wi[1]); // -0: the azimuth is -pi, not pi
    }
    const auto polar = [](const Vector& v) { return std::atan2(std::hypot(v[0], v[1]), v[2]); };
    const auto azimuth = [](const Vector& v) { return std::atan2(v[1], v[0]); };
    const Vector h{wi[0] + wo[0], wi[1] + wo[1], wi[2] + wo[2]};
    const auto to_u = [](double theta) { return std::sqrt(2 * theta / pi); };
    const auto to_v = [](double phi) {
        const double v = (phi + pi) / (2 * pi);
        return v - std::floor(v);
    };
    const double u = to_u(polar(h)), v = to_v(azimuth(h) - (isotropic ? azimuth(wi) : 0));
    const std::vector<double> p = shares(phis.values, azimuth(wi)),
                              t = shares(thetas.values, polar(wi));
    double below = 0, left = 0, along = 0; // of the mixture of densities, each of integral 1
    for (std::size_t i = 0; i < p.size() * t.size(); ++i) {
        const Square density = square_of(vndf, i);
        const double share = p[i / t.size()] * t[i % t.size()] / density.below(1);
        below += share * density.below(v);
        left += share * density.across(u, v);
        along += share * density.across(1, v);
    }
    const double factor =
        find(fields, "jacobian")->values[0] == 0
            ? 1
            : square_of(*find(fields, "ndf")).value(u, v) /
                  (4 * square_of(*find(fields, "sigma")).value(to_u(polar(wi)), to_v(azimuth(wi))));
    std::vector<double> f(table.shape[2]);
    for (std::size_t i = 0; i < p.size() * t.size(); ++i)
        for (std::size_t ch = 0; ch < f.size(); ++ch)
            f[ch] += p[i / t.size()] * t[i % t.size()] *
                     square_of(table, i * f.size() + ch).value(left / along, below) * factor /
                     wo[2];
    return f;
}

} // namespace brdfit::test
