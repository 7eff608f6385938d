// The works as loops over samples, in float64 on one thread.
#include "bench/native_tasks.hpp"

#include "host/evaluate/sample.hpp"

#include <cmath>
#include <memory>

namespace brdfit::bench {

namespace {

constexpr std::size_t channels = 3;

struct Loop {
    const ScalarModel* model;
    Problem problem;
    const std::vector<ScalarSample>& samples;
    StructureLayout layout;
    std::vector<double> a; // kd, ks of each channel
    int parameters() const { return static_cast<int>(layout.parameters.size()); }
    ScalarSums sums(const std::vector<double>& theta, Sums wanted) const {
        return model->sums(samples, theta.data(), parameters(), wanted);
    }
    Answer error(const std::vector<double>& theta, bool gradient) const {
        return solved(*model, sums(theta, gradient ? Sums::Gradient : Sums::Basis), parameters(),
                      gradient, samples.size());
    }
};
using Shared = std::shared_ptr<const Loop>;

Task task_of(const Shared& loop, const char* work) {
    return {work,
            loop->problem.name(),
            {},
            {},
            static_cast<double>(loop->samples.size()),
            static_cast<double>(sizeof(ScalarSample))};
}

Task eval_task(const Shared& loop) {
    Task task = task_of(loop, "eval");
    auto f = std::make_shared<std::vector<double>>(channels * loop->samples.size());
    task.run = [loop, f] {
        loop->model->evaluate(loop->samples, loop->problem.theta.data(), loop->a.data(), f->data());
    };
    task.answer = [loop, f] {
        Answer answer(2 * channels);
        for (std::size_t k = 0; k < loop->samples.size(); ++k)
            for (std::size_t ch = 0; ch < channels; ++ch) {
                const double x = (*f)[channels * k + ch], w = loop->samples[k].weight;
                answer[2 * ch] += w * x;
                answer[2 * ch + 1] += w * x * x;
            }
        return answer;
    };
    return task;
}

Task error_task(const Shared& loop, bool gradient) {
    Task task = task_of(loop, gradient ? "error-gradient" : "error");
    auto answer = std::make_shared<Answer>();
    task.run = [loop, answer, gradient] { *answer = loop->error(loop->problem.theta, gradient); };
    task.answer = [answer] { return *answer; };
    return task;
}

// The sums about given kd and ks, in the order of device_tasks.
Answer about_coefficients(const Loop& loop, const ScalarSums& sums) {
    const auto basis = static_cast<std::size_t>(loop.model->basis);
    const std::size_t entries = loop.layout.entries.size();
    const std::size_t gram_sums = basis * (basis + 1) / 2;
    const double norm = static_cast<double>(loop.samples.size() * channels);
    const auto gram = [&](std::size_t j, std::size_t l) {
        return j < l ? sums[l * (l + 1) / 2 + j] : sums[j * (j + 1) / 2 + l];
    };
    const auto a = [&](std::size_t ch, std::size_t j) { return loop.a[2 * ch + j]; };
    double error = sums[gram_sums + basis * channels];
    for (std::size_t ch = 0; ch < channels; ++ch)
        for (std::size_t j = 0; j < basis; ++j) {
            error -= 2 * a(ch, j) * sums[gram_sums + ch * basis + j];
            for (std::size_t l = 0; l < basis; ++l)
                error += a(ch, j) * a(ch, l) * gram(j, l);
        }
    const std::size_t first = gram_sums + basis * channels + 1, step = basis + channels;
    Answer answer{error};
    answer.insert(answer.end(), sums.begin(),
                  sums.begin() + static_cast<std::ptrdiff_t>(gram_sums));
    for (std::size_t e = 0; e < entries; ++e)
        for (std::size_t j = 0; j < basis; ++j)
            answer.push_back(sums[first + e * step + j]);
    for (std::size_t e = 0; e < entries; ++e)
        for (std::size_t ch = 0; ch < channels; ++ch) {
            double residual = sums[first + e * step + basis + ch];
            for (std::size_t j = 0; j < basis; ++j)
                residual -= a(ch, j) * sums[first + e * step + j];
            answer.push_back(residual);
        }
    answer.insert(answer.end(), sums.begin() + static_cast<std::ptrdiff_t>(first + entries * step),
                  sums.end());
    for (double& sum : answer)
        sum /= norm;
    return answer;
}

Task sums_task(const Shared& loop) {
    Task task = task_of(loop, "sums");
    auto answer = std::make_shared<Answer>();
    task.run = [loop, answer] {
        *answer = about_coefficients(*loop, loop->sums(loop->problem.theta, Sums::Normal));
    };
    task.answer = [answer] { return *answer; };
    return task;
}

// A program without batches evaluates the error of one candidate after the other.
Task search_task(const Shared& loop) {
    Task task = task_of(loop, "search");
    task.samples *= search_candidates / checked_candidates_step;
    const auto candidates = candidates_of(loop->problem, search_candidates);
    auto answer = std::make_shared<Answer>();
    task.run = [loop, answer, candidates] {
        answer->clear();
        for (std::size_t n = 0; n < candidates.size(); n += checked_candidates_step)
            answer->push_back(loop->error(candidates[n], false)[0]);
    };
    task.answer = [answer] { return *answer; };
    return task;
}

std::vector<double> anisotropic_theta(const Problem& problem) {
    const Material material = problem.material();
    return material.lobes.empty() ? std::vector<double>(1) : material.lobes[0].anisotropic_theta();
}

Task sample_task(const Shared& loop) {
    Task task = task_of(loop, "sample");
    task.samples = static_cast<double>(checked_draws);
    auto out = std::make_shared<std::vector<double>>(3 * checked_draws);
    const std::vector<double> full = anisotropic_theta(loop->problem);
    task.run = [loop, out, full] {
        loop->model->draw(checked_draws, direction(viewer_angle, 0),
                          keys_of(sampling_seed, Sequence::Sobol).data(),
                          loop->problem.theta.data(), full.data(), out->data());
    };
    task.answer = [out] {
        Answer answer(3);
        for (std::size_t k = 0; k < checked_draws; ++k) {
            const double* const drawn = out->data() + 3 * k;
            if (!(drawn[0] > 0))
                continue;
            answer[0] += drawn[0];
            answer[1] += std::log1p(drawn[1]);
            answer[2] += drawn[2];
        }
        return answer;
    };
    return task;
}

Shared loop_of(const Problem& problem, const std::vector<ScalarSample>& samples) {
    Loop loop{
        ScalarModel::find(problem.structure), problem, samples, layout_of(problem.structure), {}};
    const Material material = problem.material();
    for (std::size_t ch = 0; ch < channels; ++ch) {
        loop.a.push_back(material.kd[ch]);
        loop.a.push_back(material.lobes.empty() ? 0 : material.lobes[0].ks[ch]);
    }
    return std::make_shared<const Loop>(std::move(loop));
}

} // namespace

std::vector<Task> scalar_tasks(const Problem& problem, const std::vector<ScalarSample>& samples) {
    const Shared loop = loop_of(problem, samples);
    std::vector<Task> tasks = {eval_task(loop), error_task(loop, false), sums_task(loop),
                               error_task(loop, true)};
    if (!problem.structure.lobes.empty())
        tasks.push_back(search_task(loop));
    if (problem.structure.diffuse->kind == Kind::Diffuse)
        tasks.push_back(sample_task(loop));
    return tasks;
}

Task precomputed_task(const Problem& problem, const std::vector<ScalarSample>& samples) {
    const Shared loop = loop_of(problem, samples);
    Task task = task_of(loop, "error-gradient");
    const auto planes = static_cast<std::size_t>(loop->layout.planes);
    const auto rows = std::make_shared<std::vector<double>>(loop->model->prepare(samples, planes));
    task.bytes_per_sample = static_cast<double>((planes + channels + 1) * sizeof(double));
    auto answer = std::make_shared<Answer>();
    task.run = [loop, rows, answer, planes] {
        *answer = solved(*loop->model,
                         loop->model->row_sums(*rows, planes, loop->problem.theta.data(),
                                               loop->parameters(), Sums::Gradient),
                         loop->parameters(), true, loop->samples.size());
    };
    task.answer = [answer] { return *answer; };
    return task;
}

Calls scalar_draw_calls(const Problem& problem) {
    return ScalarModel::find(problem.structure)
        ->count_draw(1024, direction(viewer_angle, 0),
                     keys_of(sampling_seed, Sequence::Sobol).data(), problem.theta.data(),
                     anisotropic_theta(problem).data());
}

} // namespace brdfit::bench
