#include "fit/report/cards.hpp"

#include "fit/report/html.hpp"
#include "fit/report/pictures.hpp"
#include "fit/report/tables.hpp"
#include "host/error.hpp"
#include "host/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cmath>
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <mutex>

namespace brdfit {

namespace {

/// The fit that bests are set beside; lobes 0: of any number, the best.
Column chosen_column(const Overview& overview, const std::string& text) {
    if (text.empty()) {
        for (const std::string& model : overview.models()) // the least mean error first
            if (overview.has({model, overview.lobes().front()}))
                return {model, overview.lobes().front()};
        return {"", 0};
    }
    Column column{text.substr(0, text.rfind(':')), 0};
    if (column.model.size() < text.size()) {
        const char* const end = text.data() + text.size();
        const auto number =
            std::from_chars(text.data() + column.model.size() + 1, end, column.lobes);
        if (number.ec != std::errc{} || number.ptr != end || column.lobes == 0)
            throw UsageError(fmt::format("--model {}: expected MODEL or MODEL:LOBES", text));
    }
    const std::vector<std::size_t> lobes =
        column.lobes > 0 ? std::vector<std::size_t>{column.lobes} : overview.lobes();
    if (std::none_of(lobes.begin(), lobes.end(), [&](std::size_t n) {
            return overview.has({column.model, n});
        }))
        throw UsageError(fmt::format("--model {}: no fit has it; expected one of {}", text,
                                     fmt::join(overview.models(), ", ")));
    return column;
}

const ReportedFit* chosen_fit(const Overview& overview, std::size_t material,
                              const Column& column) {
    if (column.lobes > 0)
        return overview.fit(material, column);
    const ReportedFit* best = nullptr;
    for (const std::size_t lobes : overview.lobes())
        if (const ReportedFit* const fit = overview.fit(material, {column.model, lobes}))
            if (best == nullptr || fit->error() < best->error())
                best = fit;
    return best;
}

std::string parameters_html(const ReportedFit& fit) {
    std::string text = fmt::format(
        "<details><summary>{}: {} error {}{}</summary>\n<div class=\"wide\" tabindex=\"0\" "
        "role=\"region\" aria-label=\"Parameters\"><table><thead><tr><th scope=\"col\">parameter"
        "</th><th scope=\"col\">value</th><th scope=\"col\">standard error</th><th scope=\"col\">"
        "</th></tr></thead><tbody>\n",
        html(fit.name()), name_of(fit.metric), error_text(fit.error()),
        html(fmt::format("{}{}", remarks_on(fit.result).empty() ? "" : "; ",
                         fmt::join(remarks_on(fit.result), "; "))));
    for (const FittedParameter& p : fit.result.parameters)
        text +=
            fmt::format("<tr><th scope=\"row\">{}</th><td>{:.5g}</td><td>{}</td><td>{}</td></tr>\n",
                        html(column_name(p.name)), p.value,
                        std::isfinite(p.standard_error) ? fmt::format("{:.2g}", p.standard_error)
                                                        : std::string("–"),
                        p.at_bound ? "at its bound" : "");
    return text + "</tbody></table></div></details>\n";
}

/// The data, or why it is not shown.
std::shared_ptr<const MeasuredBrdf> data_of(const ReportedMaterial& material, std::string& why) {
    try {
        auto data = std::make_shared<const MeasuredBrdf>(material.file);
        if (!material.sha256.empty() && data->samples().sha256 != material.sha256)
            why = fmt::format("{} is not the file that was fitted to; expected SHA-256 {}",
                              material.file, material.sha256);
        else
            return data;
    } catch (const InputError& error) {
        why = error.what();
    }
    return nullptr;
}

// The card of material `m`, with pictures where there are some to be made.
std::string card_html(const Overview& overview, std::size_t m, const Column& column,
                      const CardPictures* pictures) {
    const ReportedMaterial& material = overview.results().materials[m];
    const ReportedFit* const best = overview.best(m);
    const ReportedFit* chosen = chosen_fit(overview, m, column);
    chosen = chosen == best ? nullptr : chosen;
    std::string text =
        fmt::format("<article class=\"card\" id=\"{}\" data-name=\"{}\"><h3>{}</h3>\n"
                    "<p class=\"settings\">{}</p>\n",
                    card_id(m), html(material.name), html(material.name), html(material.path));
    if (best == nullptr)
        text += "<p class=\"note\">No fit of it is done.</p>\n";
    if (pictures != nullptr) {
        std::string why;
        const auto data = data_of(material, why);
        if (!why.empty())
            text += fmt::format("<p class=\"note\">The data is not shown: {}</p>\n", html(why));
        if (data || best != nullptr)
            try {
                text += pictures->html_of(material.name, data, best, chosen);
            } catch (const InputError& error) { // channels that are no colours, say
                text += fmt::format("<p class=\"note\">No pictures: {}</p>\n", html(error.what()));
            }
    }
    for (const ReportedFit* fit : {best, chosen})
        if (fit != nullptr)
            text += parameters_html(*fit);
    return text + "</article>\n";
}

// Cards made at once: one leaves cores idle while it reads, encodes and builds programs.
constexpr std::size_t cards_at_once = 4;

} // namespace

std::string cards_html(const Overview& overview, const ReportOptions& options,
                       const std::function<Device()>& device) {
    const std::size_t count = overview.results().materials.size();
    const Column column = chosen_column(overview, options.model);
    std::optional<Device> opened;
    if (options.size > 0)
        opened = device();
    std::vector<std::string> cards(count);
    std::atomic<std::size_t> next{0};
    std::size_t done = 0;
    std::mutex telling;
    DeviceTurns turns;
    parallel_pieces(std::min(count, cards_at_once), 1, [&](std::size_t, std::size_t) {
        std::optional<CardPictures> pictures;
        if (opened) {
            Device own = *opened;
            own.queue = cl::CommandQueue(own.context, own.handle);
            pictures.emplace(own, options, turns);
        }
        for (std::size_t m = next++; m < count; m = next++) {
            if (options.next) {
                const std::lock_guard<std::mutex> lock(telling);
                options.next(overview.results().materials[m].name, done);
            }
            cards[m] = card_html(overview, m, column, pictures ? &*pictures : nullptr);
            const std::lock_guard<std::mutex> lock(telling);
            ++done;
        }
    });
    return fmt::format("{}", fmt::join(cards, ""));
}

} // namespace brdfit
