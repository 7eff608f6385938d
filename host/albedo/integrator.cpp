#include "host/albedo/integrator.hpp"

#include "host/device/buffer.hpp"
#include "kernels/passes/albedo.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <utility>

namespace brdfit {

namespace {

/// Independent scramblings of an integral's points.
constexpr std::size_t replicates = 16;
/// Points of a replicate in the first round, and before any integral is done; multiples of V.
constexpr cl_uint first_points = 64, fewest_points = 512;
constexpr auto most_replicate_points =
    static_cast<cl_uint>(AlbedoIntegrator::most_points / replicates);
/// What is stated as the error, in standard deviations of the replicates: six standard errors of
/// their mean. The largest of thousands of integrals must be covered, skewed ones among them.
constexpr double stated_deviations = 1.5;
/// An error that falls faster than this from one doubling to the next is not believed: scrambled
/// Sobol points reach N^-1.5 on smooth functions, and estimates can agree by chance.
constexpr double steepest_fall = 2.83;
/// Points that a group sums in float32.
constexpr cl_uint group_points = 1024;
/// Tasks a launch: their parameters fit into any device's constant memory.
constexpr std::size_t tasks_a_launch = 1024;
constexpr auto near = static_cast<double>(NEAR), nearer = static_cast<double>(NEARER);
/// A component that does not vanish at the horizon like iz^vanishing at least, but is cut off by
/// it, is integrated up to it with care; one that grows faster than iz^-vanishing has points there
/// as well, iz = u^power, by how fast it grows.
constexpr double vanishing = 0.1, fast_growth = 0.6;
constexpr cl_uint slow_power = 4, fast_power = 16;
/// What it may add to the albedo, of the tolerance, without that.
constexpr double negligible = 1e-2;
/// The least iz that float32 holds: what lies below is missed.
constexpr double least_iz = 1e-37;
/// wo.z that stand for the limit, and what the albedo may grow by from one to the other.
constexpr double towards_horizon = 1e-6, at_horizon = 1e-10, limit_growth = 1e-3;
constexpr double infinity = std::numeric_limits<double>::infinity();

std::uint32_t scramble(std::uint32_t x) { // the finaliser of MurmurHash3
    x = (x ^ (x >> 16)) * 0x85ebca6bU;
    x = (x ^ (x >> 13)) * 0xc2b2ae35U;
    return x ^ (x >> 16);
}

/// wo at another height above the horizon, of the same azimuth.
Vector raised(const Vector& wo, double z) {
    const double r = std::hypot(wo[0], wo[1]), scale = std::sqrt(1 - z * z) / r;
    return {wo[0] * scale, wo[1] * scale, z};
}

} // namespace

/// A task on its way.
struct AlbedoIntegrator::Running {
    const AlbedoTask* task;
    AlbedoTask own;      ///< what task points to where it is not the caller's
    double relative = 0; ///< tolerance relative to the value, besides the task's
    bool cut = false;    ///< whether the horizon cuts the component off
    cl_uint power = 0;   ///< of points near the horizon of wi; 0: none are needed
    double spread = 0;   ///< of the replicates, as it is believed
    double missed = 0;   ///< part of the value that lies too near the horizon to be seen
    std::array<std::array<double, ALBEDO_SUMS>, replicates> sums{};
    AlbedoValue value{};

    bool has(cl_uint strategy) const {
        if (power > 0)
            return strategy == OWN_SHARED || strategy == HORIZON;
        return strategy == (cut ? CLIPPED : OWN);
    }
};

AlbedoIntegrator::AlbedoIntegrator(const Device& device, Structure structure, std::size_t component,
                                   const std::vector<float>& shared)
    : device_(device), component_(component) {
    structure.isotropic = false;
    parameters_ = parameter_stride(structure);
    const cl::Program program = build_albedo_program(device_, structure);
    albedo_ = cl::Kernel(program, "albedo");
    horizon_ = cl::Kernel(program, "horizon");
    std::vector<cl_uint2> keys(replicates);
    for (cl_uint r = 0; r < replicates; ++r) {
        keys[r].s[0] = scramble(2 * r + 1);
        keys[r].s[1] = scramble(2 * r + 2);
    }
    keys_ = upload(device_, keys);
    directions_ = make_buffer(device_, tasks_a_launch * sizeof(cl_float4), CL_MEM_READ_ONLY);
    tasks_ = make_buffer(device_, tasks_a_launch * sizeof(cl_uint4), CL_MEM_READ_ONLY);
    thetas_ = structure.has_tables()
                  ? upload(device_, shared)
                  : make_buffer(device_, tasks_a_launch * parameters_ * sizeof(cl_float),
                                CL_MEM_READ_ONLY);
}

void AlbedoIntegrator::upload_tasks(const std::vector<const AlbedoTask*>& tasks,
                                    const std::vector<cl_uint>& strategies, cl_uint first,
                                    cl_uint count) {
    std::vector<cl_float4> directions(tasks.size());
    std::vector<cl_uint4> numbers(tasks.size());
    std::vector<cl_float> thetas(tasks.size() * parameters_);
    for (std::size_t t = 0; t < tasks.size(); ++t) {
        for (std::size_t k = 0; k < 3; ++k)
            directions[t].s[k] = static_cast<cl_float>(tasks[t]->wo[k]);
        directions[t].s[3] = static_cast<cl_float>(tasks[t]->ior);
        numbers[t] = {{static_cast<cl_uint>(component_), strategies[t], first, count}};
        for (std::size_t k = 0; parameters_ > 0 && k < tasks[t]->theta.size(); ++k)
            thetas[t * parameters_ + k] = static_cast<cl_float>(tasks[t]->theta[k]);
    }
    const auto write = [&](const cl::Buffer& buffer, const auto& data) {
        device_.queue.enqueueWriteBuffer(buffer, CL_TRUE, 0, data.size() * sizeof(data[0]),
                                         data.data());
    };
    write(directions_, directions);
    write(tasks_, numbers);
    if (parameters_ > 0)
        write(thetas_, thetas);
}

std::vector<float> AlbedoIntegrator::horizon_values(const std::vector<AlbedoTask>& tasks) {
    std::vector<float> values;
    for (std::size_t begin = 0; begin < tasks.size(); begin += tasks_a_launch) {
        std::vector<const AlbedoTask*> launch;
        for (std::size_t t = begin; t < std::min(tasks.size(), begin + tasks_a_launch); ++t)
            launch.push_back(&tasks[t]);
        upload_tasks(launch, std::vector<cl_uint>(launch.size(), OWN), 0, 0);
        const cl::Buffer out =
            make_buffer(device_, launch.size() * HORIZON_VALUES * sizeof(float), CL_MEM_WRITE_ONLY);
        horizon_.setArg(0, directions_);
        horizon_.setArg(1, tasks_);
        horizon_.setArg(2, thetas_);
        horizon_.setArg(3, static_cast<cl_uint>(launch.size()));
        horizon_.setArg(4, out);
        const auto local = static_cast<std::size_t>(device_.form.local_size);
        device_.queue.enqueueNDRangeKernel(
            horizon_, cl::NullRange, cl::NDRange(padded(launch.size(), local)), cl::NDRange(local));
        const std::vector<float> found =
            download<float>(device_, out, launch.size() * HORIZON_VALUES);
        values.insert(values.end(), found.begin(), found.end());
    }
    return values;
}

// Adds points [first, first + count) of every replicate to the tasks' sums.
void AlbedoIntegrator::add_points(const std::vector<Running*>& tasks, cl_uint first, cl_uint count,
                                  const ProgressFunction& progress) {
    const cl_uint part = std::min(count, group_points);
    const std::size_t parts = (count + part - 1) / part, groups = parts * replicates;
    const auto local = static_cast<std::size_t>(device_.form.local_size);
    const std::size_t launch_tasks =
        std::max<std::size_t>(1, std::min(tasks_a_launch, (std::size_t{1} << 18) / groups));
    if (out_() == nullptr ||
        out_.getInfo<CL_MEM_SIZE>() < launch_tasks * groups * ALBEDO_SUMS * sizeof(float))
        out_ = make_buffer(device_, launch_tasks * groups * ALBEDO_SUMS * sizeof(float),
                           CL_MEM_WRITE_ONLY);
    for (std::size_t begin = 0; begin < tasks.size(); begin += launch_tasks) {
        tell(progress, static_cast<double>(begin) / static_cast<double>(tasks.size()));
        const std::size_t size = std::min(launch_tasks, tasks.size() - begin);
        for (const cl_uint strategy : {OWN, CLIPPED, OWN_SHARED, HORIZON}) {
            std::vector<Running*> launch;
            std::vector<const AlbedoTask*> wanted;
            std::vector<cl_uint> strategies;
            for (std::size_t t = begin; t < begin + size; ++t)
                if (tasks[t]->has(strategy)) {
                    launch.push_back(tasks[t]);
                    wanted.push_back(tasks[t]->task);
                    strategies.push_back(strategy + STRATEGIES * tasks[t]->power);
                }
            if (launch.empty())
                continue;
            upload_tasks(wanted, strategies, first, count);
            albedo_.setArg(0, directions_);
            albedo_.setArg(1, tasks_);
            albedo_.setArg(2, thetas_);
            albedo_.setArg(3, keys_);
            albedo_.setArg(4, static_cast<cl_uint>(replicates));
            albedo_.setArg(5, part);
            albedo_.setArg(6, out_);
            device_.queue.enqueueNDRangeKernel(albedo_, cl::NullRange,
                                               cl::NDRange(groups * local, launch.size()),
                                               cl::NDRange(local, 1));
            const std::vector<float> sums =
                download<float>(device_, out_, launch.size() * groups * ALBEDO_SUMS);
            for (std::size_t t = 0; t < launch.size(); ++t)
                for (std::size_t g = 0; g < groups; ++g)
                    for (std::size_t k = 0; k < ALBEDO_SUMS; ++k)
                        launch[t]->sums[g % replicates][k] +=
                            static_cast<double>(sums[(t * groups + g) * ALBEDO_SUMS + k]);
        }
    }
}

// Chooses how each task is sampled by how its component grows towards the horizon; returns those
// that are not infinite.
std::vector<AlbedoIntegrator::Running*> AlbedoIntegrator::prepared(std::vector<Running>& running) {
    std::vector<AlbedoTask> tasks;
    for (const Running& r : running)
        tasks.push_back(*r.task);
    const std::vector<float> horizon = horizon_values(tasks);
    std::vector<Running*> open;
    for (std::size_t t = 0; t < running.size(); ++t) {
        Running& r = running[t];
        const double at_near = horizon[t * HORIZON_VALUES + VALUE_NEAR],
                     at_nearer = horizon[t * HORIZON_VALUES + VALUE_NEARER];
        const double growth =
            at_near > 0 ? std::log(at_nearer / at_near) / std::log(near / nearer) : 0;
        if (growth > 1 - 1e-3) { // the integral of 1/iz
            r.value = {infinity, infinity, 0, true};
            continue;
        }
        // The integral of at_near (iz / near)^-growth over the hemisphere.
        const double share = 2 * pi * at_near * std::pow(near, growth) / (1 - growth);
        if (growth > -vanishing && share > negligible * r.task->tolerance) {
            r.cut = growth < vanishing;
            if (!r.cut) {
                r.power = growth > fast_growth ? fast_power : slow_power;
                r.missed = std::pow(least_iz, 1 - growth);
            }
        }
        open.push_back(&r);
    }
    return open;
}

// Estimates a task's value and error from its replicates' sums over `points` each; returns whether
// it is done.
bool AlbedoIntegrator::estimate(Running& r, cl_uint points) {
    double mean[3] = {}, square[3] = {};
    for (const auto& sum : r.sums) {
        const double all = sum[ALBEDO_ALL], weighted = sum[ALBEDO_WEIGHTED];
        const double x[3] = {all / points, weighted / points, (all - weighted) / points};
        for (std::size_t k = 0; k < 3; ++k) {
            mean[k] += x[k] / replicates;
            square[k] += x[k] * x[k] / replicates;
        }
    }
    double spread = 0;
    for (std::size_t k = 0; k < 3; ++k)
        spread = std::max(spread, square[k] - mean[k] * mean[k]);
    spread = std::max(stated_deviations *
                          std::sqrt(std::max(0.0, spread) * replicates / (replicates - 1)),
                      r.spread / steepest_fall);
    r.spread = spread;
    const double systematic = (single_precision + r.missed) * mean[0];
    const bool last = points >= most_replicate_points;
    AlbedoValue& value = r.value;
    value.all = mean[0];
    value.weighted = mean[1];
    value.error = spread + systematic;
    value.reached = value.error <= std::max(r.task->tolerance, r.relative * mean[0]) ||
                    spread <= single_precision * mean[0] ||
                    (last && value.error <= r.task->tolerance * std::max(1.0, mean[0]));
    if (r.task->points > 0)
        return points * cl_uint{replicates} >= r.task->points;
    return value.reached && points * (r.cut ? cl_uint{STEPS} : 1) >= fewest_points;
}

// Points of a replicate that a task not yet done will have taken, about: its error falls like 1 /
// N.
double AlbedoIntegrator::points_wanted(const Running& r, cl_uint points) {
    const double tolerance = std::max({r.task->tolerance, r.relative * r.value.all,
                                       single_precision * r.value.all, least_tolerance});
    return std::clamp(points * r.spread / tolerance, 2.0 * points,
                      static_cast<double>(most_replicate_points));
}

void AlbedoIntegrator::integrate(std::vector<Running>& running, const ProgressFunction& progress) {
    std::vector<Running*> open = prepared(running);
    // Where all want so many points, in one go.
    cl_uint first = most_replicate_points;
    for (const Running* const r : open)
        first = std::min(first, std::max(first_points, r->task->points / cl_uint{replicates}));
    cl_uint points = 0;
    double done = 0, wanted = 0, told = 0; // wanted: beyond those done
    const auto told_at = [&](double all_done) {
        told = std::max(told, all_done / std::max(done + wanted, all_done));
        tell(progress, told);
    };
    while (!open.empty() && points < most_replicate_points) {
        const cl_uint more = std::max(points, first);
        const double round = static_cast<double>(more) * static_cast<double>(open.size());
        add_points(open, points, more, [&](double share) {
            if (points > 0)
                told_at(done + share * round);
            else // nothing is known before the first round
                tell(progress, told);
        });
        points += more;
        done += round;
        wanted = 0;
        std::vector<Running*> next;
        for (Running* const r : open)
            if (!estimate(*r, points)) {
                next.push_back(r);
                wanted += points_wanted(*r, points) - points;
            }
        open = std::move(next);
        told_at(done);
    }
}

std::vector<AlbedoValue> AlbedoIntegrator::integrate(const std::vector<AlbedoTask>& tasks,
                                                     const ProgressFunction& progress) {
    std::vector<AlbedoValue> values(tasks.size());
    std::vector<std::size_t> plain, limits;
    for (std::size_t t = 0; t < tasks.size(); ++t)
        if (tasks[t].tolerance < infinity)
            (tasks[t].wo[2] < at_horizon ? limits : plain).push_back(t);
    const auto all = static_cast<double>(3 * limits.size() + plain.size());
    double begun = 0;
    const auto running_at = [&](const std::vector<std::size_t>& chosen, double z, double relative) {
        std::vector<Running> running(chosen.size());
        for (std::size_t i = 0; i < chosen.size(); ++i) {
            const AlbedoTask& task = tasks[chosen[i]];
            running[i].task = &task;
            running[i].relative = std::max(relative, task.relative);
            if (z > 0) {
                running[i].own = task;
                running[i].own.wo = raised(task.wo, z);
            }
        }
        for (Running& r : running)
            if (z > 0)
                r.task = &r.own;
        const double end = begun + static_cast<double>(chosen.size()) / all;
        integrate(running, part_of(progress, std::exchange(begun, end), end));
        return running;
    };
    // Whether the limit is finite shows at a coarse tolerance.
    const std::vector<Running> before = running_at(limits, towards_horizon, limit_growth);
    const std::vector<Running> after = running_at(limits, at_horizon, limit_growth);
    std::vector<std::size_t> finite;
    for (std::size_t i = 0; i < limits.size(); ++i) {
        const AlbedoValue &low = after[i].value, &high = before[i].value;
        if (low.all > high.all * (1 + limit_growth) + low.error + high.error)
            values[limits[i]] = {infinity, infinity, 0, true};
        else
            finite.push_back(limits[i]);
    }
    for (const auto& [chosen, z] : {std::pair(finite, at_horizon), std::pair(plain, 0.0)}) {
        const std::vector<Running> done = running_at(chosen, z, 0);
        for (std::size_t i = 0; i < chosen.size(); ++i)
            values[chosen[i]] = done[i].value;
    }
    return values;
}

} // namespace brdfit
