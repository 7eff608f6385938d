#include "fit/report/tables.hpp"

#include "fit/report/html.hpp"

#include <cmath>
#include <fmt/format.h>

namespace brdfit {

namespace {

std::string failure_id(std::size_t failure) {
    return fmt::format("f{}", failure);
}

std::string lobes_text(std::size_t lobes) {
    return fmt::format("{} lobe{}", lobes, lobes == 1 ? "" : "s");
}

/// A header cell by which the script sorts.
std::string column_head(const std::string& name, const std::string& attributes = "") {
    return fmt::format("<th scope=\"col\"{}><button type=\"button\">{}</button></th>", attributes,
                       html(name));
}

/// All four errors, which the script shows by choice, and the one that was minimised as text.
std::string error_cell(const ReportedFit& fit, bool best) {
    std::string all;
    for (const double error : fit.result.errors)
        all += (all.empty() ? "" : " ") + fmt::format("{:.4g}", error);
    return fmt::format("<td data-v=\"{}\"{}>{}</td>", all, best ? " class=\"best\"" : "",
                       error_text(fit.error()));
}

void add_row(std::string& text, const Overview& overview, std::size_t material, std::size_t lobes,
             const std::vector<Column>& columns) {
    text += fmt::format("<tr><th scope=\"row\"><a href=\"#{}\">{}</a></th>", card_id(material),
                        html(overview.results().materials[material].name));
    const ReportedFit* const best = overview.best(material, lobes);
    for (const Column& column : columns) {
        const ReportedFit* const fit = overview.fit(material, column);
        if (fit != nullptr)
            text += error_cell(*fit, fit == best);
        else if (const auto failure = overview.failure(material, column))
            text += fmt::format("<td class=\"no\"><a href=\"#{}\">failed</a></td>",
                                failure_id(*failure));
        else
            text += "<td class=\"no\">–</td>";
    }
    text += "</tr>\n";
}

} // namespace

std::string error_text(double error) {
    return fmt::format("{:#.4g}", error);
}

std::string card_id(std::size_t material) {
    return fmt::format("m{}", material);
}

std::string settings_html(const Results& results) {
    std::string text = "<dl class=\"settings\">\n";
    for (const auto& [name, value] : results.settings)
        text += fmt::format("<div><dt>{}</dt><dd>{}</dd></div>\n", html(name), html(value));
    return text + "</dl>\n";
}

std::string troubles_html(const Results& results) {
    std::string text;
    for (const std::string& note : results.notes)
        text += fmt::format("<p class=\"note\">{}</p>\n", html(note));
    if (results.failures.empty())
        return text;
    text += fmt::format("<h2>Failed fits</h2>\n<div class=\"wide\" tabindex=\"0\" role=\"region\" "
                        "aria-label=\"Failed fits\"><table class=\"failed\"><thead><tr>"
                        "<th scope=\"col\">material</th><th scope=\"col\">model</th>"
                        "<th scope=\"col\">lobes</th><th scope=\"col\">reason</th></tr></thead>"
                        "<tbody>\n");
    for (std::size_t i = 0; i < results.failures.size(); ++i) {
        const ReportedFailure& failure = results.failures[i];
        text += fmt::format("<tr id=\"{}\"><th scope=\"row\">{}</th><td>{}</td><td>{}</td>"
                            "<td class=\"words\">{}</td></tr>\n",
                            failure_id(i), html(results.materials[failure.material].name),
                            failure.model.empty() ? "all" : html(failure.model),
                            failure.model.empty() ? "" : fmt::format("{}", failure.lobes),
                            html(failure.reason));
    }
    return text + "</tbody></table></div>\n";
}

std::string models_html(const Overview& overview) {
    std::string text = "<div class=\"wide\" tabindex=\"0\" role=\"region\" aria-label=\"Models\">"
                       "<table class=\"sortable\"><thead><tr>" +
                       column_head("model");
    for (const std::size_t lobes : overview.lobes()) {
        text += column_head("best of " + lobes_text(lobes));
        text += column_head("mean error, " + lobes_text(lobes));
        if (lobes > overview.lobes().front())
            text += column_head(fmt::format("lobe {} lowers it by", lobes));
    }
    text += "</tr></thead><tbody>\n";
    const auto cell = [](double value, const std::string& shown) {
        return std::isfinite(value) ? fmt::format("<td data-v=\"{:.6g}\">{}</td>", value, shown)
                                    : std::string("<td class=\"no\">–</td>");
    };
    for (const std::string& model : overview.models()) {
        text += fmt::format("<tr><th scope=\"row\">{}</th>", html(model));
        for (const std::size_t lobes : overview.lobes()) {
            const Column column{model, lobes};
            const double mean = overview.mean(column), gain = overview.gain(column);
            const auto wins = static_cast<double>(overview.wins(column));
            text += cell(std::isfinite(mean) ? wins : mean, fmt::format("{:g}", wins));
            text += cell(mean, error_text(mean));
            if (lobes > overview.lobes().front())
                text += cell(gain, fmt::format("{:.1f} %", 100 * gain));
        }
        text += "</tr>\n";
    }
    return text + "</tbody></table></div>\n";
}

std::string errors_html(const Overview& overview) {
    std::string text;
    const std::size_t materials = overview.results().materials.size();
    for (const std::size_t lobes : overview.lobes()) {
        std::vector<Column> columns;
        for (const std::string& model : overview.models())
            if (overview.has({model, lobes}))
                columns.push_back({model, lobes});
        text += fmt::format("<section class=\"lobes\" data-lobes=\"{0}\">\n<h3>{1}</h3>\n"
                            "<div class=\"wide\" tabindex=\"0\" role=\"region\" "
                            "aria-label=\"Errors with {1}\"><table class=\"sortable errors\">"
                            "<thead><tr>{2}",
                            lobes, lobes_text(lobes), column_head("material"));
        for (const Column& column : columns)
            text += column_head(column.model);
        text += "</tr></thead><tbody>\n";
        for (std::size_t m = 0; m < materials; ++m)
            add_row(text, overview, m, lobes, columns);
        text += "</tbody><tfoot><tr><th scope=\"row\">mean</th>";
        for (const Column& column : columns) {
            const double mean = overview.mean(column);
            text += std::isfinite(mean) ? fmt::format("<td>{}</td>", error_text(mean))
                                        : std::string("<td class=\"no\">–</td>");
        }
        text += "</tr></tfoot></table></div>\n</section>\n";
    }
    return text;
}

} // namespace brdfit
