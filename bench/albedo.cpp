#include "bench/albedo.hpp"

#include "host/table/table.hpp"

namespace brdfit::bench {

Result measure_table(const Device& device, const Model& model, std::size_t size) {
    TableSpec spec = *find_preset("materialx");
    set_model(spec, model);
    TableSpec warm_up = spec;
    set_size(warm_up, 2);
    compute_table(device, warm_up);
    set_size(spec, size);
    Task task;
    task.work = table_work;
    task.model = model.name;
    task.samples = static_cast<double>(spec.entries());
    task.run = [&] { compute_table(device, spec); };
    return measure(task, device.name, static_cast<int>(device.compute_units), {0, 1, 3, 1.0});
}

} // namespace brdfit::bench
