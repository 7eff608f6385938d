#include "bench/tune.hpp"

#include "bench/native_tasks.hpp"
#include "bench/opencl.hpp"
#include "bench/report.hpp"
#include "host/device/tuning.hpp"

#include <cmath>

namespace brdfit::bench {

namespace {

constexpr const char* tuned_works[] = {"eval", "error-gradient", "search"};

bool is_tuned(const Task& task) {
    return std::find(std::begin(tuned_works), std::end(tuned_works), task.work) !=
           std::end(tuned_works);
}

} // namespace

std::vector<Form> forms_for(const Device& device) {
    std::vector<Form> forms = {shipped_form(device)};
    const auto add = [&](const Form& form) {
        if (is_possible(form, device) && !(form == forms.front()))
            forms.push_back(form);
    };
    if (device.vectors) {
        for (const int width : {16, 8, 4})
            for (const int block : {1024, 2048, 4096})
                for (const int candidates : {1, 2, 4})
                    add({width, 1, block, candidates});
    } else {
        for (const int local : {64, 128, 256})
            for (const int block : {2048, 8192, 32768})
                for (const int candidates : {2, 4, 8})
                    add({1, local, block, candidates});
    }
    return forms;
}

std::vector<Tried> try_forms(const Device& device, const std::vector<Form>& forms,
                             const Samples& data, const std::function<void(std::size_t)>& next) {
    const Problem problem = problems({"kurt"}).front();
    const std::vector<ScalarSample> samples = scalar_samples(data);
    std::vector<Result> results;
    for (const Task& task : scalar_tasks(problem, samples))
        if (is_tuned(task))
            results.push_back(measure(task, baseline, 1, {0, 1, 1, 0}));
    const std::size_t references = results.size();
    std::vector<Tried> all;
    for (std::size_t i = 0; i < forms.size(); ++i) {
        next(i);
        Device changed = device;
        changed.form = forms[i];
        Tried tried{forms[i]};
        double product = 1;
        std::size_t works = 0;
        results.resize(references);
        for (const Task& task : device_tasks(changed, problem, data)) {
            if (!is_tuned(task))
                continue;
            // The best run: forms are told apart by what they can do, not by what disturbs them.
            const double speed = task.samples / time_runs(task.run, {2, 8, 60, 0.15}).best;
            Result result;
            result.device = device.name;
            result.work = task.work;
            result.model = task.model;
            result.answer = task.answer();
            results.push_back(std::move(result));
            double Tried::*const place = task.work == "eval"     ? &Tried::eval
                                         : task.work == "search" ? &Tried::search
                                                                 : &Tried::gradient;
            tried.*place = speed;
            product *= (all.empty() ? speed : all.front().*place) / speed;
            ++works;
        }
        check_answers(results);
        tried.slowness = std::pow(product, 1.0 / static_cast<double>(works));
        all.push_back(tried);
    }
    return all;
}

} // namespace brdfit::bench
