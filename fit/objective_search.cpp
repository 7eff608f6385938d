// The passes of Objective that the global search needs.
#include "fit/objective.hpp"

#include "host/device/buffer.hpp"
#include "kernels/passes/sums.h"

#include <chrono>
#include <utility>

namespace brdfit {

namespace {

bool is_fresnel(const Structure& structure) {
    return !structure.lobes.empty() && structure.lobes.back()->fresnel();
}

} // namespace

// A constant buffer holds at least 64 KiB.
std::size_t Objective::candidates_a_batch() const {
    return (std::size_t{1} << 16) / sizeof(float) /
           std::max<std::size_t>(layout().parameters.size(), 1);
}

FixedSums Objective::fixed_sums() {
    // Coupled shapes scale with 1 - f0: f0 = 0 stands for all. The lobe only has to be finite.
    std::vector<double> theta;
    for (const Parameter& p : layout().parameters)
        theta.push_back(p.name == "f0" ? 0 : p.start);
    const int basis = layout().basis, chunk = samples_.chunk;
    const Eigen::Index gram_sums = TRIANGLE(basis);
    const Eigen::Index sums = BASIS_SUMS(basis, chunk);
    const Reduced reduced = run("basis_sums", theta, Coefficients::Zero(samples_.channels, basis),
                                static_cast<std::size_t>(sums), samples_.chunks, false);
    FixedSums fixed{reduced.sums(0, 0), reduced.sums.row(sums - 1).sum(), {}};
    for (int ch = 0; ch < samples_.channels; ++ch)
        fixed.by.push_back(reduced.sums(gram_sums + (ch % chunk) * basis, ch / chunk));
    return fixed;
}

// Sums of a candidate in the kernel's order.
ShapeSums Objective::shape_of(const Eigen::ArrayXXd& sums, std::size_t candidate) const {
    const auto chunk = static_cast<std::size_t>(samples_.chunk);
    const bool fresnel = is_fresnel(structure());
    const std::size_t count = SHAPE_SUMS(fresnel, chunk);
    const auto at = [&](std::size_t sum, std::size_t of_chunk) {
        return sums(static_cast<Eigen::Index>(candidate * count + sum),
                    static_cast<Eigen::Index>(of_chunk));
    };
    ShapeSums s{at(SHAPE_SS, 0), at(SHAPE_SB, 0), 0, 0, 0, {}, {}};
    if (fresnel) {
        s.st = at(SHAPE_ST, 0);
        s.tt = at(SHAPE_TT, 0);
        s.tb = at(SHAPE_TB, 0);
    }
    const std::size_t first_sy = count - chunk; // the last ones
    for (std::size_t ch = 0; ch < static_cast<std::size_t>(samples_.channels); ++ch) {
        s.ty.push_back(fresnel ? at(SHAPE_FIRST_Y + ch % chunk, ch / chunk) : 0);
        s.sy.push_back(at(first_sy + ch % chunk, ch / chunk));
    }
    return s;
}

std::vector<ShapeSums> Objective::shape_sums(const std::vector<std::vector<double>>& candidates) {
    const auto width = static_cast<std::size_t>(device_.form.vector_width);
    const auto local = static_cast<std::size_t>(device_.form.local_size);
    const auto tile = static_cast<std::size_t>(device_.form.candidates);
    const auto chunk = static_cast<std::size_t>(samples_.chunk);
    const auto chunks = static_cast<std::size_t>(samples_.chunks);
    const std::size_t parameters = layout().parameters.size();
    const std::size_t sums = SHAPE_SUMS(is_fresnel(structure()), chunk);
    const cl::Buffer diffuse_theta =
        upload(device_, std::vector<float>(std::max<std::size_t>(parameters, 1), 0.0F));
    const auto started = std::chrono::steady_clock::now();
    bool fresh = false;
    cl::Kernel& k = kernel("shape_sums", &fresh);
    std::vector<ShapeSums> result;
    for (std::size_t begin = 0; begin < candidates.size();) {
        const std::size_t count = std::min(candidates_a_batch(), candidates.size() - begin);
        const std::size_t tiles = (count + tile - 1) / tile;
        std::vector<float> theta;
        for (std::size_t n = begin; n < begin + count; ++n)
            theta.insert(theta.end(), candidates[n].begin(), candidates[n].end());
        theta.resize(std::max<std::size_t>(theta.size(), 1));
        const cl::Buffer theta_buffer = upload(device_, theta);
        const std::size_t outputs = chunks * samples_.groups * tiles * tile * sums;
        const cl::Buffer out = make_buffer(device_, outputs * sizeof(float), CL_MEM_WRITE_ONLY);
        k.setArg(0, planes_);
        k.setArg(1, samples_.values);
        k.setArg(2, samples_.weights);
        k.setArg(3, static_cast<cl_uint>(samples_.stride / width));
        k.setArg(4, theta_buffer);
        k.setArg(5, static_cast<cl_int>(parameters));
        k.setArg(6, static_cast<cl_uint>(count));
        k.setArg(7, diffuse_theta);
        k.setArg(8, out);
        std::vector<float> partial;
        {
            const std::lock_guard<std::mutex> lock(program_->running);
            device_.queue.enqueueNDRangeKernel(k, cl::NullRange,
                                               cl::NDRange(tiles * local, samples_.groups, chunks),
                                               cl::NDRange(local, 1, 1));
            partial = download<float>(device_, out, outputs);
        }
        if (std::exchange(fresh, false))
            count_first_run(started);
        const std::size_t all = tiles * tile * sums;
        Eigen::ArrayXXd total =
            Eigen::ArrayXXd::Zero(static_cast<Eigen::Index>(all), samples_.chunks);
        for (std::size_t c = 0; c < chunks; ++c)
            for (std::size_t group = 0; group < samples_.groups; ++group)
                total.col(static_cast<Eigen::Index>(c)) +=
                    Eigen::Map<const Eigen::ArrayXf>(partial.data() +
                                                         (c * samples_.groups + group) * all,
                                                     static_cast<Eigen::Index>(all))
                        .cast<double>();
        total /= samples_.norm();
        for (std::size_t n = 0; n < count; ++n)
            result.push_back(shape_of(total, n));
        begin += count;
    }
    return result;
}

void Objective::write_fixed_rows(const cl::Buffer& rows) {
    const auto width = static_cast<std::size_t>(device_.form.vector_width);
    // Coupled shapes scale with 1 - f0: f0 = 0 stands for all.
    upload_parameters(std::vector<double>(layout().parameters.size(), 0.0), reference_);
    const auto started = std::chrono::steady_clock::now();
    bool fresh = false;
    cl::Kernel& k = kernel("fixed_rows", &fresh);
    k.setArg(0, planes_);
    k.setArg(1, samples_.values);
    k.setArg(2, samples_.weights);
    k.setArg(3, static_cast<cl_uint>(samples_.stride / width));
    k.setArg(4, theta_);
    k.setArg(5, rows);
    const std::lock_guard<std::mutex> lock(program_->running);
    enqueue_runs(device_, k, samples_.stride / width);
    device_.queue.finish();
    if (fresh)
        count_first_run(started);
}

void Objective::write_shape_rows(const cl::Buffer& rows, std::size_t first,
                                 const std::vector<std::vector<double>>& candidates) {
    if (candidates.empty())
        return;
    const auto width = static_cast<std::size_t>(device_.form.vector_width);
    const std::size_t parameters = candidates.front().size();
    const std::size_t batch = candidates_a_batch();
    const auto started = std::chrono::steady_clock::now();
    bool fresh = false;
    cl::Kernel& k = kernel("shape_rows", &fresh);
    for (std::size_t begin = 0; begin < candidates.size(); begin += batch) {
        const std::size_t end = std::min(begin + batch, candidates.size());
        std::vector<float> theta;
        for (std::size_t n = begin; n < end; ++n)
            theta.insert(theta.end(), candidates[n].begin(), candidates[n].end());
        const cl::Buffer theta_buffer = upload(device_, theta);
        k.setArg(0, planes_);
        k.setArg(1, samples_.weights);
        k.setArg(2, static_cast<cl_uint>(samples_.stride / width));
        k.setArg(3, theta_buffer);
        k.setArg(4, static_cast<cl_int>(parameters));
        k.setArg(5, static_cast<cl_uint>(first + begin));
        k.setArg(6, rows);
        const std::lock_guard<std::mutex> lock(program_->running);
        enqueue_runs(device_, k, samples_.stride / width, end - begin);
        device_.queue.finish();
        if (std::exchange(fresh, false))
            count_first_run(started);
    }
}

} // namespace brdfit
