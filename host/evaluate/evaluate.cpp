#include "host/evaluate/evaluate.hpp"

#include "host/device/buffer.hpp"
#include "host/error.hpp"
#include "host/model/program.hpp"

#include <algorithm>
#include <fmt/format.h>

namespace brdfit {

namespace {

constexpr std::size_t pairs_a_pass = std::size_t{1} << 18;

MakePairs copies_of(const Directions& directions) {
    return [&directions](std::size_t first, std::size_t count, Directions& into) {
        for (int p = 0; p < Directions::plane_count; ++p) {
            const auto plane = static_cast<Directions::Plane>(p);
            std::copy_n(directions.plane(plane) + first, count, into.plane(plane));
        }
    };
}

} // namespace

std::vector<float> run_over_directions(const Device& device, cl::Kernel& kernel,
                                       cl_uint out_argument, std::size_t outputs, std::size_t total,
                                       const MakePairs& make, const ProgressFunction& progress) {
    const auto width = static_cast<std::size_t>(device.form.vector_width);
    const std::size_t pass =
        std::min({pairs_a_pass, padded(total, width),
                  device.max_allocation /
                      (sizeof(float) * std::max<std::size_t>(outputs, Directions::plane_count)) /
                      width * width});
    std::vector<float> result(outputs * total);
    Directions staged(pass);
    std::vector<float> values(pass * outputs);
    const cl::Buffer in =
        make_buffer(device, staged.data().size() * sizeof(float), CL_MEM_READ_ONLY);
    const cl::Buffer out = make_buffer(device, values.size() * sizeof(float), CL_MEM_WRITE_ONLY);
    kernel.setArg(0, in);
    kernel.setArg(out_argument, out);
    for (std::size_t begin = 0; begin < total; begin += pass) {
        const std::size_t count = std::min(pass, total - begin);
        const std::size_t stride = padded(count, width);
        if (stride < staged.count()) // the last ones; padding has wi.z = 0: below the horizon
            staged = Directions(stride);
        make(begin, count, staged);
        device.queue.enqueueWriteBuffer(in, CL_TRUE, 0, staged.data().size() * sizeof(float),
                                        staged.data().data());
        kernel.setArg(1, static_cast<cl_uint>(stride / width));
        enqueue_runs(device, kernel, stride / width);
        device.queue.enqueueReadBuffer(out, CL_TRUE, 0, stride * outputs * sizeof(float),
                                       values.data());
        for (std::size_t o = 0; o < outputs; ++o)
            std::copy_n(values.begin() + static_cast<std::ptrdiff_t>(o * stride), count,
                        result.begin() + static_cast<std::ptrdiff_t>(o * total + begin));
        tell(progress, static_cast<double>(begin + count) / static_cast<double>(total));
    }
    return result;
}

std::vector<float> run_over_directions(const Device& device, cl::Kernel& kernel,
                                       cl_uint out_argument, std::size_t outputs,
                                       const Directions& directions,
                                       const ProgressFunction& progress) {
    return run_over_directions(device, kernel, out_argument, outputs, directions.count(),
                               copies_of(directions), progress);
}

std::vector<float> device_parameters(const Material& material, bool isotropic) {
    std::vector<float> words;
    bool tables = false;
    for (const Lobe& lobe : material.lobes) {
        const std::vector<double> theta = isotropic ? lobe.theta : lobe.anisotropic_theta();
        words.insert(words.end(), theta.begin(), theta.end());
        tables = tables || lobe.model->table;
    }
    if (!tables)
        return words;
    const std::size_t offsets = words.size();
    words.resize(offsets + material.lobes.size());
    for (std::size_t l = 0; l < material.lobes.size(); ++l) {
        const Lobe& lobe = material.lobes[l];
        if (!lobe.model->table)
            continue;
        words[offsets + l] = static_cast<float>(words.size());
        TableUse use;
        use.f0 = lobe.theta.empty() ? 0 : lobe.theta[0];
        use.correlated = lobe.correlated;
        use.metal = material.metal;
        const std::vector<float> packed = packed_for_lobe(*lobe.table, use);
        words.insert(words.end(), packed.begin(), packed.end());
    }
    if (words.size() > most_table_words)
        throw InputError(fmt::format("the material's tables have {} values; expected at most 2^24, "
                                     "what kernels can address",
                                     words.size()));
    return words;
}

Evaluator::Evaluator(const Device& device, const Material& material)
    : device_(device), channels_(material.channels.size()) {
    Structure structure;
    structure.diffuse = material.diffuse;
    structure.isotropic = std::all_of(material.lobes.begin(), material.lobes.end(),
                                      [](const Lobe& lobe) { return lobe.isotropic; });
    const std::size_t basis = 1 + material.lobes.size();
    std::vector<double> coefficients(channels_ * basis);
    for (std::size_t ch = 0; ch < channels_; ++ch)
        coefficients[ch * basis] = material.kd[ch];
    for (std::size_t l = 0; l < material.lobes.size(); ++l) {
        const Lobe& lobe = material.lobes[l];
        structure.lobes.push_back(lobe.model);
        for (std::size_t ch = 0; ch < channels_; ++ch)
            coefficients[ch * basis + l + 1] = lobe.ks[ch];
    }
    program_ = build_program(device_, structure, 1, 1);
    theta_ = upload(device_, device_parameters(material, structure.isotropic));
    coefficients_ = upload(device_, to_float(coefficients));
}

std::vector<float> Evaluator::values(std::size_t count, const MakePairs& make,
                                     const ProgressFunction& progress) const {
    cl::Kernel kernel(program_, "evaluate");
    kernel.setArg(2, theta_);
    kernel.setArg(3, coefficients_);
    kernel.setArg(4, static_cast<cl_int>(channels_));
    return run_over_directions(device_, kernel, 5, channels_, count, make, progress);
}

std::vector<float> evaluate(const Device& device, const Material& material,
                            const Directions& directions, const ProgressFunction& progress) {
    return Evaluator(device, material).values(directions.count(), copies_of(directions), progress);
}

ModelValues evaluate_model(const Device& device, const Model& model, bool isotropic,
                           const std::vector<double>& theta, const Directions& directions) {
    if (model.table)
        throw UsageError(fmt::format("{} needs a table; evaluate a material with it", model.name));
    Structure structure;
    structure.isotropic = isotropic;
    const bool lobe = model.kind == Kind::Lobe;
    structure.diffuse = lobe ? &model_named("lambert") : &model;
    if (lobe)
        structure.lobes.push_back(&model);
    const StructureLayout layout = layout_of(structure);
    const cl::Program program = build_program(device, structure, 1, 1);
    cl::Kernel kernel(program, "evaluate_basis");
    const cl::Buffer theta_buffer = upload(device, to_float(theta));
    kernel.setArg(2, theta_buffer);
    const std::size_t basis = static_cast<std::size_t>(layout.basis);
    const std::vector<float> planes =
        run_over_directions(device, kernel, 3, basis + layout.entries.size(), directions);
    const auto plane = [&](std::size_t p) {
        const auto begin = planes.begin() + static_cast<std::ptrdiff_t>(p * directions.count());
        return std::vector<float>(begin, begin + static_cast<std::ptrdiff_t>(directions.count()));
    };
    ModelValues values;
    values.value = plane(basis - 1);
    for (std::size_t e = 0; e < layout.entries.size(); ++e)
        values.derivatives.push_back(plane(basis + e));
    return values;
}

} // namespace brdfit
