#pragma once

#include <nanobind/nanobind.h>

// What each file adds to the module _brdfit: what Python needs of the library, nothing that Python
// can do itself. Structured values cross as JSON, a material as the text of its file.

namespace brdfit::python {

void add_catalogue(nanobind::module_& module);
void add_samples(nanobind::module_& module);
void add_material(nanobind::module_& module);
void add_render(nanobind::module_& module);
void add_fit(nanobind::module_& module);
void add_compare(nanobind::module_& module);
void add_tables(nanobind::module_& module);
void add_runs(nanobind::module_& module);

} // namespace brdfit::python
