# The works, what they are compared with, and the commands bench and tune: the library brdfit_bench.
include(CheckCXXCompilerFlag)
include(bench/native/scalar_models.cmake)

file(GLOB BENCH CONFIGURE_DEPENDS bench/*.cpp bench/native/*.cpp bench/cli/*.cpp)
list(FILTER BENCH EXCLUDE REGEX "native_simd.cpp$")
add_library(brdfit_bench STATIC ${BENCH})
target_link_libraries(brdfit_bench PUBLIC brdfit_core CLI11::CLI11)

# The baselines: one for this processor and OpenMP where the compiler can, the others with the flags
# everything has. Both say how they were compiled.
string(TOUPPER "${CMAKE_BUILD_TYPE}" BUILD_TYPE)
string(STRIP "${CMAKE_CXX_FLAGS} ${CMAKE_CXX_FLAGS_${BUILD_TYPE}}" SCALAR_FLAGS)
set(NATIVE_DEFINITIONS "BRDFIT_SCALAR_FLAGS=\"${SCALAR_FLAGS}\""
  "BRDFIT_COMPILER=\"${CMAKE_CXX_COMPILER_ID} ${CMAKE_CXX_COMPILER_VERSION}\"")
check_cxx_compiler_flag(-march=native COMPILER_KNOWS_NATIVE)
find_package(OpenMP COMPONENTS CXX)
if(BRDFIT_SIMD_BASELINE AND COMPILER_KNOWS_NATIVE AND OpenMP_CXX_FOUND)
  set(SIMD_FLAGS -O3 -march=native -ffast-math ${OpenMP_CXX_FLAGS})
  list(JOIN SIMD_FLAGS " " SIMD_FLAGS_TEXT)
  list(APPEND NATIVE_DEFINITIONS "BRDFIT_SIMD_FLAGS=\"${SIMD_FLAGS_TEXT}\"")
  target_sources(brdfit_bench PRIVATE bench/native/native_simd.cpp)
  set_source_files_properties(bench/native/native_simd.cpp PROPERTIES COMPILE_OPTIONS "${SIMD_FLAGS}"
    SKIP_PRECOMPILE_HEADERS ON)
  target_link_libraries(brdfit_bench PRIVATE ${OpenMP_CXX_LIBRARIES})
endif()
set_source_files_properties(bench/simd_tasks.cpp PROPERTIES COMPILE_DEFINITIONS "${NATIVE_DEFINITIONS}")
scalar_models(SCALAR_MODELS)
set_source_files_properties(bench/native/scalar.cpp PROPERTIES COMPILE_OPTIONS "-I${SCALAR_MODELS};-Wno-maybe-uninitialized") # of numbers of parameters no model has

# Google Benchmark's view of what the host does.
find_package(benchmark QUIET)
if(BUILD_TESTING AND benchmark_FOUND)
  add_executable(brdfit_micro bench/micro/host_parts.cpp)
  target_link_libraries(brdfit_micro PRIVATE brdfit_bench benchmark::benchmark)
  add_test(NAME micro_benchmarks COMMAND brdfit_micro --benchmark_min_time=0)
  set_tests_properties(micro_benchmarks PROPERTIES TIMEOUT 300 ENVIRONMENT BRDFIT_TUNING=)
endif()
