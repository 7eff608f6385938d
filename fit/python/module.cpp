#include "fit/python/module.hpp"

#include "fit/python/call.hpp"
#include "host/version.hpp"

NB_MODULE(_brdfit, module) {
    module.doc() = "What the package brdfit calls; use that.";
    module.attr("version") = brdfit::version;
    brdfit::python::collect_warnings();
    brdfit::python::translate_errors(module);
    brdfit::python::add_catalogue(module);
    brdfit::python::add_samples(module);
    brdfit::python::add_material(module);
    brdfit::python::add_render(module);
    brdfit::python::add_fit(module);
    brdfit::python::add_compare(module);
    brdfit::python::add_tables(module);
    brdfit::python::add_runs(module);
}
