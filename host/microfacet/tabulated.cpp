#include "host/error.hpp"
#include "host/files/text.hpp"
#include "host/image/image.hpp"
#include "host/microfacet/distribution.hpp"

#include <algorithm>
#include <cmath>
#include <fmt/format.h>
#include <map>

// Tabulated distributions in files.

namespace brdfit {

namespace {

constexpr std::size_t max_values = std::size_t{1} << 20;

/// Throws where the nodes do not ascend within their range.
void check_nodes(const std::vector<double>& nodes, const char* name, double upper, bool inclusive,
                 const std::string& source) {
    for (std::size_t i = 0; i < nodes.size(); ++i) {
        const bool within =
            nodes[i] >= 0 && (inclusive ? nodes[i] <= upper + 1e-5 : nodes[i] < upper);
        if (!within || (i > 0 && !(nodes[i] > nodes[i - 1])))
            throw InputError(fmt::format(
                "{}: {} {} is {:g}; expected ascending angles in radians from 0 {} {:g}", source,
                name, i, nodes[i], inclusive ? "to" : "and below", upper));
    }
}

void check_grid(const DirectionTable& table, const std::string& source) {
    if (table.height < 2 || table.height * table.width > max_values)
        throw InputError(
            fmt::format("{}: has {} polar angles and {} azimuths; expected at least 2 polar angles "
                        "and at most {} values",
                        source, table.height, table.width, max_values));
    check_nodes(table.thetas, "theta_h", pi, true, source);
    check_nodes(table.phis, "phi_h", 2 * pi, false, source);
    check_values(table, source);
}

std::vector<double> node_list(const std::string& text, const std::string& source,
                              const std::string& name, std::size_t expected) {
    std::vector<std::string_view> fields;
    text::split(text, ',', fields);
    if (fields.size() != expected)
        throw InputError(fmt::format("{}: attribute {} lists {} angles; expected {}", source, name,
                                     fields.size(), expected));
    const text::Lines lines(text, source);
    std::vector<double> nodes;
    for (const std::string_view field : fields)
        nodes.push_back(text::number(lines, name, field));
    return nodes;
}

std::shared_ptr<const DirectionTable> read_tabulated_exr(const std::string& path) {
    const Image image = read_exr(path);
    const std::vector<float>* values = image.plane("p");
    if (values == nullptr)
        values = image.plane("Y");
    if (values == nullptr)
        throw InputError(fmt::format("{}: has channels {}; expected p or Y", path,
                                     fmt::join(image.channels, ", ")));
    auto table = std::make_shared<DirectionTable>();
    table->width = image.width;
    table->height = image.height;
    table->values = *values;
    const auto nodes = [&](const char* name, std::size_t count, double last, bool round) {
        const auto listed = image.metadata.find(name);
        if (listed != image.metadata.end())
            return node_list(listed->second, path, name, count);
        std::vector<double> even(count);
        for (std::size_t i = 0; i < count; ++i)
            even[i] = last * static_cast<double>(i) /
                      static_cast<double>(round ? count : std::max<std::size_t>(count - 1, 1));
        return even;
    };
    table->thetas = nodes("theta_h", table->height, pi / 2, false);
    table->phis = nodes("phi_h", table->width, 2 * pi, true);
    check_grid(*table, path);
    return table;
}

std::shared_ptr<const DirectionTable> read_tabulated_csv(const std::string& path) {
    const MappedFile file(path);
    text::Lines lines(file);
    std::vector<std::string_view> fields;
    if (!lines.next())
        lines.fail_file("has no header; expected theta_h,phi_h,p or theta_h,p");
    text::split(lines.line(), ',', fields);
    const std::vector<std::string> header(fields.begin(), fields.end());
    const bool isotropic = header == std::vector<std::string>{"theta_h", "p"};
    if (!isotropic && header != std::vector<std::string>{"theta_h", "phi_h", "p"})
        lines.fail("is " + text::quoted(lines.line()) +
                   "; expected the header theta_h,phi_h,p or theta_h,p");
    std::map<std::pair<double, double>, float> rows;
    while (lines.next()) {
        text::split(lines.line(), ',', fields);
        if (fields.size() != header.size())
            lines.fail(fmt::format("has {} fields; expected {}", fields.size(), header.size()));
        const double theta = text::number(lines, "theta_h", fields[0]);
        const double phi = isotropic ? 0 : text::number(lines, "phi_h", fields[1]);
        const double p = text::number(lines, "p", fields.back());
        if (p < 0)
            lines.fail(fmt::format("p is {:g}; expected at least 0", p));
        if (!rows.emplace(std::pair(theta, phi), static_cast<float>(p)).second)
            lines.fail("repeats a direction; expected each once");
        if (rows.size() > max_values)
            lines.fail(fmt::format("is one too many; expected at most {} rows", max_values));
    }
    auto table = std::make_shared<DirectionTable>();
    std::map<double, std::size_t> phis;
    for (const auto& [at, p] : rows) {
        if (table->thetas.empty() || table->thetas.back() != at.first)
            table->thetas.push_back(at.first);
        phis.emplace(at.second, 0);
        table->values.push_back(p);
    }
    for (const auto& [phi, unused] : phis)
        table->phis.push_back(phi);
    table->width = table->phis.size();
    table->height = table->thetas.size();
    if (table->values.size() != table->width * table->height)
        lines.fail_file(fmt::format("has {} rows of {} polar angles and {} azimuths; expected each "
                                    "pair of them",
                                    table->values.size(), table->height, table->width));
    check_grid(*table, path);
    return table;
}

} // namespace

void check_values(const DirectionTable& table, const std::string& source) {
    bool any = false;
    for (std::size_t i = 0; i < table.values.size(); ++i) {
        const float p = table.values[i];
        if (!std::isfinite(p) || p < 0)
            throw InputError(
                fmt::format("{}: value {} in row {}, column {}; expected finite values "
                            "of at least 0",
                            source, p, i / table.width, i % table.width));
        any = any || p > 0;
    }
    if (!any)
        throw InputError(fmt::format("{}: every value is 0; expected a positive one", source));
}

std::shared_ptr<const DirectionTable> read_tabulated(const std::string& path) {
    const MappedFile file(path);
    const bool exr = file.bytes().substr(0, 4) == std::string_view("\x76\x2f\x31\x01", 4);
    return exr ? read_tabulated_exr(path) : read_tabulated_csv(path);
}

} // namespace brdfit
