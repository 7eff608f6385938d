#include "host/python/module.hpp"

#include "host/python/call.hpp"
#include "host/version.hpp"

#include <memory>
#include <spdlog/sinks/null_sink.h>
#include <spdlog/spdlog.h>

NB_MODULE(_brdfit, module) {
    module.doc() = "What the package brdfit calls; use that.";
    module.attr("version") = brdfit::version;
    // What the library says is for the program that links it; Python hears by exceptions.
    spdlog::set_default_logger(std::make_shared<spdlog::logger>(
        "brdfit", std::make_shared<spdlog::sinks::null_sink_mt>()));
    brdfit::python::translate_errors(module);
    brdfit::python::add_catalogue(module);
    brdfit::python::add_samples(module);
    brdfit::python::add_material(module);
    brdfit::python::add_fit(module);
    brdfit::python::add_tables(module);
    brdfit::python::add_runs(module);
}
