#pragma once

#include "host/device/device.hpp"
#include "host/directions.hpp"
#include "host/model/program.hpp"
#include "host/progress.hpp"

#include <cstdint>
#include <vector>

namespace brdfit {

/// The least tolerance an albedo can be asked for, and the part of an albedo that single precision
/// may be off by.
inline constexpr double least_tolerance = 5e-6, single_precision = 2e-6;

/// An integral wanted: of one component for one wo.
struct AlbedoTask {
    Vector wo;                 ///< unit, wo.z >= 0; 0 stands for the limit towards the horizon
    std::vector<double> theta; ///< of the structure's lobes, anisotropic form; values may lie
                               ///< beyond the catalogue's ranges
    double tolerance = 1e-4;   ///< absolute; infinite: not wanted
    double ior = 0;            ///< index of refraction that AlbedoValue::weighted is for, or 0
    double relative = 0;       ///< tolerance relative to the value; either tolerance will do
    /// Above 0: at least so many points, whatever their error, up to most_points; the value is then
    /// smooth in theta but where a component begins to grow towards the horizon.
    std::uint32_t points = 0;
};

/// integral over wi of g iz, and of g iz weighted: by (1 - c)^5 for ior 0, otherwise by Fresnel's
/// reflectance of a dielectric of that index. With g at f0 = 1 the first two give Schlick's F of
/// any f0: f0 (all - weighted) + weighted.
struct AlbedoValue {
    double all = 0, weighted = 0; ///< infinite where the integral diverges
    double error = 0;             ///< estimated, of each of them and of their difference
    bool reached = true;          ///< whether error is within the tolerance
};

/// Integrates one component of a structure by its own sampler with scrambled Sobol points, on the
/// device, many directions and parameters at once. Each integral is estimated with independent
/// scramblings and goes on, doubling its points, until their spread says that the tolerance is
/// reached, or that single precision is (2e-6 of the value). The error stated is the spread of the
/// estimates (six standard errors of their mean) plus that part.
/// Components that grow towards the horizon (kurt beyond alpha = 1) are sampled there as well;
/// those that grow like 1/iz or faster have no finite albedo, and neither have those that keep
/// growing as wo goes to the horizon.
class AlbedoIntegrator {
  public:
    /// `component`: 0 diffuse, 1.. lobes. `shared`: where the structure has tables, the parameters
    /// of every task (see device_parameters); their own are not looked at. Throws like
    /// build_program.
    AlbedoIntegrator(const Device& device, Structure structure, std::size_t component,
                     const std::vector<float>& shared = {});

    /// The integrals, in the tasks' order; the same numbers whatever the number of threads. Work is
    /// bounded by most_points a task.
    std::vector<AlbedoValue> integrate(const std::vector<AlbedoTask>& tasks,
                                       const ProgressFunction& progress = {});

    static constexpr std::size_t most_points = std::size_t{1} << 22;

  private:
    struct Running;
    std::vector<Running*> prepared(std::vector<Running>& running);
    static bool estimate(Running& r, cl_uint points);
    static double points_wanted(const Running& r, cl_uint points);
    void integrate(std::vector<Running>& running, const ProgressFunction& progress);
    void add_points(const std::vector<Running*>& tasks, cl_uint first, cl_uint count,
                    const ProgressFunction& progress);
    std::vector<float> horizon_values(const std::vector<AlbedoTask>& tasks);
    void upload_tasks(const std::vector<const AlbedoTask*>& tasks,
                      const std::vector<cl_uint>& strategies, cl_uint first, cl_uint count);

    Device device_;
    std::size_t component_, parameters_; ///< parameters_ 0: shared by all tasks
    cl::Kernel albedo_, horizon_;
    cl::Buffer keys_, directions_, tasks_, thetas_, out_;
};

} // namespace brdfit
