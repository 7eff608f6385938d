#include "fit/compare.hpp"
#include "fit/python/call.hpp"
#include "fit/python/material.hpp"
#include "fit/python/module.hpp"
#include "fit/python/samples.hpp"
#include "host/files/json.hpp"

#include <memory>
#include <nanobind/stl/string.h>

// Two materials or measurements, against each other.

namespace brdfit::python {

namespace {

// One of what is compared: a material, or otherwise samples.
struct Compared {
    const SharedMaterial* material = nullptr;
    SampleSet* samples = nullptr;

    explicit Compared(const nb::object& object) {
        if (!nb::try_cast(object, material))
            samples = nb::cast<SampleSet*>(object);
    }
    Brdf brdf() const {
        return material != nullptr ? Brdf(material->material()) : Brdf(samples->brdf());
    }
};

} // namespace

void add_compare(nb::module_& module) {
    module.def(
        "compare",
        [](const nb::object& a, const nb::object& b, double max_theta, std::size_t worst,
           const std::string& device, const nb::object& progress) {
            const Compared first(a), second(b);
            return run(progress, [&](Call& call) {
                const ComparedValues values = values_to_compare(
                    opened(device), first.brdf(), second.brdf(), "a", "b", call.progress());
                Json json =
                    comparison_json(brdfit::compare(values, max_theta, worst), values, max_theta);
                return json.dump();
            });
        },
        nb::arg("a"), nb::arg("b"), nb::arg("max_theta"), nb::arg("worst"), nb::arg("device"),
        nb::arg("progress").none());
}

} // namespace brdfit::python
