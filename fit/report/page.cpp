#include "fit/report/page.hpp"

#include "fit/report/cards.hpp"
#include "fit/report/figures.hpp"
#include "fit/report/html.hpp"
#include "fit/report/tables.hpp"
#include "host/embedded.hpp"
#include "host/error.hpp"
#include "host/image/plot.hpp"
#include "host/version.hpp"

#include <fmt/format.h>
#include <map>

namespace brdfit {

namespace {

std::string embedded(const std::string& name) {
    for (const EmbeddedFile* file = embedded_report; file->name != nullptr; ++file)
        if (name == file->name)
            return file->text;
    throw std::logic_error(name + ": is not embedded");
}

/// The template with {{NAME}} replaced; what is put in is not looked at again.
std::string filled(const std::string& page, const std::map<std::string, std::string>& parts) {
    std::string text;
    std::size_t at = 0;
    for (std::size_t open = page.find("{{"); open != std::string::npos;
         open = page.find("{{", at)) {
        const std::size_t close = page.find("}}", open);
        text += page.substr(at, open - at) + parts.at(page.substr(open + 2, close - open - 2));
        at = close + 2;
    }
    return text + page.substr(at);
}

std::string counted(std::size_t count, const char* what) {
    return fmt::format("{} {}{}", count, what, count == 1 ? "" : "s");
}

} // namespace

std::string report_page(const Results& results, const ReportOptions& options,
                        const std::function<Device()>& device) {
    const Overview overview(results);
    const std::string cards = cards_html(overview, options, device);
    std::string metrics;
    for (int i = 0; i < metric_count; ++i) {
        const auto metric = static_cast<Metric>(i);
        metrics +=
            fmt::format("<option{}>{}</option>",
                        metric == results.metric ? " selected=\"selected\"" : "", name_of(metric));
    }
    const std::string title =
        fmt::format("Fits of {} to {}", counted(overview.models().size(), "model"),
                    counted(results.materials.size(), "material"));
    const std::string lead = fmt::format(
        "{}{}; what was minimised is the error {}.", counted(results.fits.size(), "fit"),
        results.failures.empty() ? std::string()
                                 : fmt::format(", {} failed", results.failures.size()),
        name_of(results.metric));
    return filled(embedded("page.html"), {{"title", title},
                                          {"lead", lead},
                                          {"css", plot_style() + ("\n" + embedded("page.css"))},
                                          {"js", embedded("page.js")},
                                          {"settings", settings_html(results)},
                                          {"troubles", troubles_html(results)},
                                          {"metric", name_of(results.metric)},
                                          {"models", models_html(overview)},
                                          {"figures", figures_html(overview)},
                                          {"metrics", metrics},
                                          {"errors", errors_html(overview)},
                                          {"cards", cards},
                                          {"version", version}});
}

} // namespace brdfit
