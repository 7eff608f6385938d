#include "host/evaluate/rgl.hpp"

#include "host/device/buffer.hpp"
#include "host/device/kernels.hpp"
#include "host/evaluate/evaluate.hpp"
#include "kernels/passes/warp.h"

namespace brdfit {

namespace {

/// For each slice its density, whose integral is 1 where cells have side 1, the integrals along
/// rows up to each node, and those over the rows below each.
std::vector<float> packed_warps(const RglTables& tables) {
    const RglTables::Grid& vndf = tables.vndf;
    const std::size_t width = vndf.width, height = vndf.height, plane = vndf.count();
    std::vector<float> words(tables.slices() * (2 * plane + height));
    std::vector<double> along(plane), below(height);
    for (std::size_t slice = 0; slice < tables.slices(); ++slice) {
        const float* const values = vndf.values.data() + slice * plane;
        for (std::size_t y = 0; y < height; ++y) {
            double* const row = along.data() + y * width;
            for (std::size_t x = 1; x < width; ++x)
                row[x] =
                    row[x - 1] +
                    (static_cast<double>(values[y * width + x - 1]) + values[y * width + x]) / 2;
            if (y > 0)
                below[y] = below[y - 1] + (row[width - 1] + *(row - 1)) / 2;
        }
        const double scale = 1 / below.back();
        float* out = words.data() + slice * (2 * plane + height);
        for (std::size_t i = 0; i < plane; ++i)
            *out++ = static_cast<float>(values[i] * scale);
        for (const double sum : along)
            *out++ = static_cast<float>(sum * scale);
        for (const double sum : below)
            *out++ = static_cast<float>(sum * scale);
    }
    return words;
}

std::vector<cl_int> shape_of(const RglTables& tables) {
    std::vector<cl_int> shape(WARP_SHAPES);
    const auto set = [&](warp_shape word, std::size_t value) {
        shape[word] = static_cast<cl_int>(value);
    };
    set(PHI_NODES, tables.phi_i.size());
    set(THETA_NODES, tables.theta_i.size());
    shape[ISOTROPIC] = tables.isotropic();
    shape[REDUCTION] = tables.reduction();
    shape[JACOBIAN] = tables.jacobian;
    set(NDF_WIDTH, tables.ndf.width);
    set(NDF_HEIGHT, tables.ndf.height);
    set(SIGMA_WIDTH, tables.sigma.width);
    set(SIGMA_HEIGHT, tables.sigma.height);
    set(VNDF_WIDTH, tables.vndf.width);
    set(VNDF_HEIGHT, tables.vndf.height);
    set(TABLE_WIDTH, tables.table.width);
    set(TABLE_HEIGHT, tables.table.height);
    set(CHANNELS, tables.channels.size());
    return shape;
}

} // namespace

std::vector<float> evaluate(const Device& device, const RglTables& tables,
                            const Directions& directions, const ProgressFunction& progress) {
    const cl::Program program =
        build_kernels(device,
                      "#define ROUGHNESSES 2\n" +
                          kernel_texts({"base/common.cl", "base/direction_planes.h",
                                        "base/geometry.cl", "passes/warp.h", "passes/warp.cl"}),
                      "RGL files");
    std::vector<float> nodes;
    for (const auto* part :
         {&tables.phi_i, &tables.theta_i, &tables.ndf.values, &tables.sigma.values})
        nodes.insert(nodes.end(), part->begin(), part->end());
    const cl::Buffer shape_buffer = upload(device, shape_of(tables));
    const cl::Buffer node_buffer = upload(device, nodes);
    const cl::Buffer warp_buffer = upload(device, packed_warps(tables));
    const cl::Buffer table_buffer = upload(device, tables.table.values);
    cl::Kernel kernel(program, "warp");
    kernel.setArg(2, shape_buffer);
    kernel.setArg(3, node_buffer);
    kernel.setArg(4, warp_buffer);
    kernel.setArg(5, table_buffer);
    return run_over_directions(device, kernel, 6, tables.channels.size(), directions, progress);
}

} // namespace brdfit
