# The Python module: a thin extension _brdfit beside the package's files in build/python/brdfit, where
# PYTHONPATH=build/python finds it. One binary serves CPython 3.10 and later: nanobind's own code comes from its
# package nanobind-backend.
find_package(Python 3.10 COMPONENTS Interpreter Development.Module REQUIRED)
execute_process(COMMAND ${Python_EXECUTABLE} -m nanobind --cmake_dir OUTPUT_VARIABLE nanobind_ROOT
  OUTPUT_STRIP_TRAILING_WHITESPACE RESULT_VARIABLE NO_NANOBIND ERROR_QUIET)
if(NO_NANOBIND)
  message(FATAL_ERROR "BRDFIT_PYTHON needs nanobind: ${Python_EXECUTABLE} -m pip install 'nanobind>=3' nanobind-backend, "
    "or name another Python with -DPython_EXECUTABLE=...")
endif()
find_package(nanobind 3 CONFIG REQUIRED)

set(PYTHON_PACKAGE ${PROJECT_BINARY_DIR}/python/brdfit)
file(GLOB PYTHON_SOURCES CONFIGURE_DEPENDS fit/python/*.cpp)
nanobind_add_module(_brdfit BACKEND_MODULE nanobind_backend STABLE_ABI NOMINSIZE NB_SUPPRESS_WARNINGS ${PYTHON_SOURCES})
target_link_libraries(_brdfit PRIVATE brdfit_core)
target_link_options(_brdfit PRIVATE -Wl,--exclude-libs,ALL) # nothing but its entry is for others
set_target_properties(_brdfit PROPERTIES LIBRARY_OUTPUT_DIRECTORY ${PYTHON_PACKAGE})
nanobind_add_stub(_brdfit_stub MODULE _brdfit OUTPUT ${PYTHON_PACKAGE}/_brdfit.pyi PYTHON_PATH ${PYTHON_PACKAGE}
  DEPENDS _brdfit)

file(GLOB PACKAGE_FILES CONFIGURE_DEPENDS fit/python/brdfit/*.py fit/python/brdfit/py.typed)
foreach(FILE ${PACKAGE_FILES})
  get_filename_component(NAME ${FILE} NAME)
  configure_file(${FILE} ${PYTHON_PACKAGE}/${NAME} COPYONLY)
endforeach()

install(TARGETS _brdfit DESTINATION brdfit COMPONENT python EXCLUDE_FROM_ALL)
install(FILES ${PYTHON_PACKAGE}/_brdfit.pyi DESTINATION brdfit COMPONENT python EXCLUDE_FROM_ALL)
