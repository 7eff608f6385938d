#include "bench/opencl.hpp"

#include "bench/native_tasks.hpp"
#include "fit/objective.hpp"
#include "fit/programs.hpp"
#include "host/device/buffer.hpp"
#include "host/device/cache.hpp"
#include "host/device/kernels.hpp"
#include "host/evaluate/sample.hpp"
#include "kernels/passes/peaks.h"

#include <cmath>
#include <memory>

namespace brdfit::bench {

namespace {

constexpr double whole_hemisphere = 90;
constexpr double float_bytes = sizeof(float);

// What the tasks of one model share.
struct ModelOnDevice {
    ModelOnDevice(const Device& device, const Problem& problem, const Samples& samples)
        : device(device), problem(problem),
          packed(pack_samples(device, samples, whole_hemisphere, Metric::Ngan)), cache(device),
          objective(device, cache.get(problem.structure, packed.channels, packed.chunk), packed),
          counts(ScalarModel::find(problem.structure)
                     ->count(scalar_samples(samples), problem.theta.data())),
          material(problem.material()) {
        a.resize(packed.channels, objective.layout().basis);
        for (Eigen::Index ch = 0; ch < a.rows(); ++ch) {
            a(ch, 0) = material.kd[static_cast<std::size_t>(ch)];
            if (a.cols() > 1)
                a(ch, 1) = material.lobes[0].ks[static_cast<std::size_t>(ch)];
        }
    }

    const Device& device;
    const Problem problem;
    DeviceSamples packed;
    ProgramCache cache;
    Objective objective;
    ScalarModel::Counts counts;
    Material material;
    Coefficients a;

    double planes_and_values() const {
        return float_bytes * (objective.layout().planes + packed.channels + 1);
    }
    Task task(const char* work) const {
        const auto count = static_cast<double>(packed.count);
        return {work,
                problem.name(),
                {},
                {},
                count,
                planes_and_values(),
                count * planes_and_values(),
                counts.value};
    }
};
using Shared = std::shared_ptr<ModelOnDevice>;

// A kernel of evaluate.cl on directions that stay on the device.
struct Evaluation {
    cl::Buffer directions, theta, coefficients, values;
    std::size_t stride = 0; // pairs, padded to vectors
    cl::Kernel kernel;
};

std::optional<Task> eval_task(const Shared& model, const Samples& samples) {
    const Device& device = model->device;
    const std::vector<std::uint32_t>& used = model->packed.used;
    const auto channels = static_cast<std::size_t>(model->packed.channels);
    auto e = std::make_shared<Evaluation>();
    e->stride = padded(used.size(), static_cast<std::size_t>(device.form.vector_width));
    std::vector<float> planes(Directions::plane_count * e->stride);
    for (std::size_t p = 0; p < Directions::plane_count; ++p) {
        const float* const from = samples.directions->plane(static_cast<Directions::Plane>(p));
        for (std::size_t k = 0; k < used.size(); ++k)
            planes[p * e->stride + k] = from[used[k]];
    }
    e->directions = upload(device, planes);
    std::vector<double> theta = model->problem.theta;
    theta.resize(std::max<std::size_t>(theta.size(), 1));
    e->theta = upload(device, to_float(theta));
    e->coefficients =
        upload(device, to_float({model->a.data(), model->a.data() + model->a.size()}));
    e->values = make_buffer(device, channels * e->stride * sizeof(float), CL_MEM_WRITE_ONLY);
    const auto program =
        model->cache.get(model->problem.structure, model->packed.channels, model->packed.chunk);
    e->kernel = cl::Kernel(program->program, "evaluate");
    const std::size_t count = e->stride / static_cast<std::size_t>(device.form.vector_width);
    e->kernel.setArg(0, e->directions);
    e->kernel.setArg(1, static_cast<cl_uint>(count));
    e->kernel.setArg(2, e->theta);
    e->kernel.setArg(3, e->coefficients);
    e->kernel.setArg(4, static_cast<cl_int>(channels));
    e->kernel.setArg(5, e->values);
    Task task = model->task("eval");
    task.bytes_per_sample = float_bytes * (Directions::plane_count + static_cast<double>(channels));
    task.calls = {model->counts.prepare.exp + model->counts.value.exp,
                  model->counts.prepare.log + model->counts.value.log};
    task.run = [model, e, count] {
        enqueue_runs(model->device, e->kernel, count);
        model->device.queue.finish();
    };
    task.answer = [model, e, channels] {
        const std::vector<float> f =
            download<float>(model->device, e->values, channels * e->stride);
        const std::vector<float> weights =
            download<float>(model->device, model->packed.weights, model->packed.count);
        Answer answer;
        for (std::size_t ch = 0; ch < channels; ++ch) {
            double sum = 0, squares = 0;
            for (std::size_t k = 0; k < weights.size(); ++k) {
                const double x = f[ch * e->stride + k];
                sum += weights[k] * x;
                squares += weights[k] * x * x;
            }
            answer.insert(answer.end(), {sum, squares});
        }
        return answer;
    };
    return task;
}

std::optional<Task> error_task(const Shared& model, const Samples&) {
    Task task = model->task("error");
    auto error = std::make_shared<double>();
    task.run = [model, error] { *error = model->objective.projected_error(model->problem.theta); };
    task.answer = [error] { return Answer{*error}; };
    return task;
}

std::optional<Task> gradient_task(const Shared& model, const Samples&) {
    Task task = model->task("error-gradient");
    auto answer = std::make_shared<Answer>();
    task.run = [model, answer] {
        std::vector<double> gradient;
        *answer = {model->objective.projected_error(model->problem.theta, &gradient)};
        answer->insert(answer->end(), gradient.begin(), gradient.end());
    };
    task.answer = [answer] { return *answer; };
    return task;
}

std::optional<Task> sums_task(const Shared& model, const Samples&) {
    Task task = model->task("sums");
    auto sums = std::make_shared<NormalSums>();
    task.run = [model, sums] {
        *sums = model->objective.normal_sums(model->problem.theta, model->a);
    };
    task.answer = [sums] {
        Answer answer{sums->squared_error};
        const auto add = [&](const Eigen::MatrixXd& matrix, bool symmetric) {
            for (Eigen::Index i = 0; i < matrix.rows(); ++i)
                for (Eigen::Index j = 0; j <= (symmetric ? i : matrix.cols() - 1); ++j)
                    answer.push_back(matrix(i, j));
        };
        add(sums->basis, true);
        add(sums->entry_basis, false);
        add(sums->entry_residual, false);
        add(sums->entry_entry, true);
        return answer;
    };
    return task;
}

std::optional<Task> search_task(const Shared& model, const Samples&) {
    if (model->problem.structure.lobes.empty())
        return std::nullopt;
    Task task = model->task("search");
    task.samples *= search_candidates;
    task.bytes_per_sample /= search_candidates;
    const auto candidates = candidates_of(model->problem, search_candidates);
    auto sums = std::make_shared<std::vector<ShapeSums>>();
    task.run = [model, sums, candidates] { *sums = model->objective.shape_sums(candidates); };
    task.answer = [model, sums] {
        // Where the diffuse shape is coupled its f0 only changes kd.
        const FixedSums fixed = model->objective.fixed_sums();
        Answer answer;
        for (std::size_t n = 0; n < sums->size(); n += checked_candidates_step) {
            const ShapeSums& s = (*sums)[n];
            SmallMatrix gram(2, 2);
            gram << fixed.bb, s.sb, s.sb, s.ss;
            double error = fixed.yy;
            for (std::size_t ch = 0; ch < s.sy.size(); ++ch) {
                SmallVector projected(2);
                projected << fixed.by[ch], s.sy[ch];
                error += solve_nonnegative(gram, projected, 0, SmallVector::Zero(2)).squared_error;
            }
            answer.push_back(error);
        }
        return answer;
    };
    return task;
}

std::optional<Task> sample_task(const Shared& model, const Samples&) {
    if (model->problem.structure.diffuse->kind != Kind::Diffuse)
        return std::nullopt; // its lobe's sampler
    Material material = model->material;
    material.channels = {"Y"};
    material.kd = {material.lobes.empty() ? 1.0 : 0.0};
    for (Lobe& lobe : material.lobes)
        lobe.ks = {1};
    auto sampler = std::make_shared<Sampler>(model->device, material);
    const Vector wo = direction(viewer_angle, 0);
    const std::size_t n = sampler->samples_a_pass();
    Task task = model->task("sample");
    task.samples = static_cast<double>(n);
    task.bytes_per_sample = float_bytes * 5; // wi, pdf and weight
    task.working_set = task.samples * task.bytes_per_sample;
    task.calls = scalar_draw_calls(model->problem);
    task.run = [sampler, wo, n] { sampler->draw(wo, n, sampling_seed, Sequence::Sobol); };
    task.answer = [sampler, wo] {
        const DirectionSamples drawn =
            sampler->sample(wo, checked_draws, sampling_seed, Sequence::Sobol);
        Answer answer(3);
        for (std::size_t k = 0; k < drawn.count(); ++k) {
            if (!(drawn.wi_z[k] > 0))
                continue;
            answer[0] += drawn.wi_z[k];
            answer[1] += std::log1p(drawn.pdf[k]);
            answer[2] += drawn.weights[k];
        }
        return answer;
    };
    return task;
}

constexpr std::optional<Task> (*makers[])(const Shared&, const Samples&) = {
    eval_task, error_task, sums_task, gradient_task, search_task, sample_task};

} // namespace

std::vector<Task> device_tasks(const Device& device, const Problem& problem,
                               const Samples& samples) {
    const auto model = std::make_shared<ModelOnDevice>(device, problem, samples);
    std::vector<Task> tasks;
    for (const auto make : makers)
        if (std::optional<Task> task = make(model, samples))
            tasks.push_back(std::move(*task));
    return tasks;
}

Peaks measure_peaks(const Device& device, std::size_t most_bytes) {
    const cl::Program program = build_peaks_program(device);
    const auto width = static_cast<std::size_t>(device.form.vector_width);
    const auto local = static_cast<std::size_t>(device.form.local_size);
    const auto block_bytes = static_cast<std::size_t>(device.form.block) * sizeof(float);
    Peaks peaks{device.name, static_cast<int>(device.compute_units), 0, 0, {}};
    const auto seconds_of = [&](cl::Kernel& kernel, std::size_t group_count) {
        return time_runs(
                   [&] {
                       device.queue.enqueueNDRangeKernel(kernel, cl::NullRange,
                                                         cl::NDRange(group_count * local),
                                                         cl::NDRange(local));
                       device.queue.finish();
                   },
                   {1, 5, 60, 0.12})
            .median;
    };

    const std::size_t all_groups = std::max<std::size_t>(most_bytes / block_bytes, 1);
    const cl::Buffer data = make_buffer(device, all_groups * block_bytes);
    const cl::Buffer sums = make_buffer(device, all_groups * sizeof(float), CL_MEM_WRITE_ONLY);
    device.queue.enqueueFillBuffer(data, 1.0F, 0, all_groups * block_bytes);
    cl::Kernel read(program, "read_memory");
    read.setArg(0, data);
    read.setArg(1, sums);
    for (const std::size_t part : {32, 16, 8, 4, 1}) {
        const std::size_t groups = std::max<std::size_t>(all_groups / part, 1);
        const auto bytes = static_cast<double>(groups * block_bytes);
        peaks.reading.push_back({bytes, bytes / seconds_of(read, groups)});
    }

    constexpr int rounds = 512;
    const std::size_t call_groups = 64 * std::max(1U, device.compute_units);
    const cl::Buffer out = make_buffer(device, call_groups * sizeof(float), CL_MEM_WRITE_ONLY);
    const auto calls_per_second = [&](const char* name) {
        cl::Kernel kernel(program, name);
        kernel.setArg(0, static_cast<cl_int>(rounds));
        kernel.setArg(1, out);
        return static_cast<double>(call_groups * local * width * rounds * CHAINS) /
               seconds_of(kernel, call_groups);
    };
    peaks.exp_per_second = calls_per_second("exp_calls");
    peaks.log_per_second = calls_per_second("log_calls");
    return peaks;
}

std::vector<std::pair<std::string, std::string>> one_thread_environment(const Device& device) {
    if (!device.cpu)
        return {};
    if (has_sub_devices(device))
        return {{"BRDFIT_UNITS", "1"}};
    if (is_pocl(device.platform))
        return {{"POCL_MAX_PTHREAD_COUNT", "1"}};
    if (device.name.rfind("llvmpipe", 0) == 0)
        return {{"LP_NUM_THREADS", "1"}};
    return {};
}

} // namespace brdfit::bench
