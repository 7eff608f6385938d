#include "host/model/catalogue.hpp"
#include "fit/python/call.hpp"
#include "fit/python/module.hpp"

#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>
#include <utility>

// The devices and the models.

namespace brdfit::python {

namespace {

// Coupled diffuse shapes have the parameters of their lobe.
const Model& with_parameters(const Model& model) {
    return model.lobe.empty() ? model : model_named(model.lobe);
}

std::vector<Model> listed_models() {
    std::vector<Model> listed;
    for (const auto* models : {&catalogue(), &table_models()})
        for (const Model& model : *models)
            if (model.listed())
                listed.push_back(model);
    return listed;
}

} // namespace

void add_catalogue(nb::module_& module) {
    nb::class_<Device>(module, "Device", "An OpenCL device.")
        .def_ro("index", &Device::index, "Its place in devices(), which names it.")
        .def_ro("name", &Device::name, "As its driver names it.")
        .def_ro("platform", &Device::platform, "The driver's platform.")
        .def_ro("vendor", &Device::vendor, "Whose it is.")
        .def_ro("version", &Device::version, "The version of OpenCL.")
        .def_ro("driver", &Device::driver, "The version of its driver.")
        .def_ro("cpu", &Device::cpu, "Whether it is a CPU.")
        .def_ro("compute_units", &Device::compute_units, "Cores of a CPU.")
        .def_ro("global_memory", &Device::global_memory, "Bytes.")
        .def_ro("local_memory", &Device::local_memory, "Bytes.")
        .def_ro("max_allocation", &Device::max_allocation, "Bytes of one buffer at most.")
        .def("__repr__", [](const Device& device) {
            return "<brdfit.Device " + std::to_string(device.index) + ": " + device.name + " (" +
                   device.platform + ")>";
        });
    module.def("devices", &known_devices);
    module.def("default_device", [] { return default_device(known_devices()); });

    nb::class_<Parameter>(module, "Parameter", "A parameter of a lobe model.")
        .def_ro("name", &Parameter::name, "As material files name it.")
        .def_ro("lower", &Parameter::lower, "Least value.")
        .def_ro("upper", &Parameter::upper, "Largest value.")
        .def_ro("default", &Parameter::start, "A typical value.")
        .def("__repr__", [](const Parameter& p) {
            return nb::str("<brdfit.Parameter {} in [{}, {}]>").format(p.name, p.lower, p.upper);
        });
    nb::class_<Model>(module, "Model", "A model of reflectance, as the catalogue has it.")
        .def_ro("name", &Model::name, "What fit() and material files call it.")
        .def_prop_ro(
            "kind", [](const Model& m) { return m.kind == Kind::Lobe ? "lobe" : "diffuse"; },
            "'lobe' or 'diffuse'.")
        .def_ro("shape", &Model::shape, "Its formula.")
        .def_ro("equation", &Model::equation, "Paper and equation.")
        .def_ro("reciprocal", &Model::reciprocal, "Whether wi and wo may change places.")
        .def_ro("conserves_energy", &Model::conserves_energy,
                "Whether its albedo is at most 1, whatever its parameters.")
        .def_ro("table", &Model::table, "Whether it reads a table that generate() makes.")
        .def_prop_ro(
            "isotropic", [](const Model& m) { return with_parameters(m).isotropic; },
            "Parameters of the isotropic form.")
        .def_prop_ro(
            "anisotropic", [](const Model& m) { return with_parameters(m).anisotropic; },
            "Parameters of the anisotropic form.")
        .def("__repr__",
             [](const Model& m) { return "<brdfit.Model " + m.name + ": " + m.equation + ">"; });
    module.def("models", &listed_models);
}

} // namespace brdfit::python
