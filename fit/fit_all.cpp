#include "fit/fit_all.hpp"

#include "host/device/errors.hpp"

#include <algorithm>
#include <atomic>
#include <deque>
#include <memory>
#include <mutex>
#include <spdlog/spdlog.h>
#include <string>
#include <system_error>
#include <thread>
#include <utility>

namespace brdfit {

namespace {

Device with_queue(Device device, cl::CommandQueue queue) {
    device.queue = std::move(queue);
    return device;
}

// What a device failed with, for people; empty where it is not to blame.
std::string failure_of_device(const std::exception_ptr& failure) {
    try {
        std::rethrow_exception(failure);
    } catch (const DeviceError& error) {
        return error.what();
    } catch (const cl::Error& error) {
        return message_of(error);
    } catch (...) {
        return "";
    }
}

// Structures of the same models, which one thread fits: they share planes, and those of more lobes
// wait for those of fewer.
using Group = std::vector<std::size_t>;

std::deque<Group> groups_of(const std::vector<Structure>& structures) {
    std::deque<Group> groups;
    for (std::size_t i = 0; i < structures.size(); ++i) {
        const auto known = std::find_if(groups.begin(), groups.end(), [&](const Group& group) {
            return same_planes(structures[group.front()], structures[i]);
        });
        if (known != groups.end())
            known->push_back(i);
        else
            groups.push_back({i});
    }
    return groups;
}

// The samples on a device, from what it has of the file already.
DeviceSamples packed_on(const Device& device, const Samples& samples, const FitOptions& options,
                        std::optional<DeviceSamples>* known) {
    if (known == nullptr)
        return pack_samples(device, samples, options.max_theta, options.metric);
    if (*known)
        return packed_for(options.metric, device, samples, **known);
    return known->emplace(pack_samples(device, samples, options.max_theta, options.metric));
}

} // namespace

/// Fits to one file that threads on several devices take from.
class FitQueue {
  public:
    FitQueue(FitDevices& devices, const std::vector<Structure>& structures, Metric metric,
             const FitPlace& place, const FitCalls& calls)
        : devices_(devices), structures_(structures), metric_(metric), place_(place), calls_(calls),
          groups_(groups_of(structures)), group_count_(groups_.size()),
          working_(devices.size(), !place.home), failed_(devices.size(), false) {
        for (const Group& group : groups_)
            left_ += cost(group);
        if (place.home)
            working_[*place.home] = true;
    }

    // The devices to make what is left; none where nothing is, or it is time to stop.
    std::vector<std::size_t> working() {
        const std::lock_guard<std::mutex> lock(mutex_);
        std::vector<std::size_t> devices;
        for (std::size_t d = 0; d < devices_.size() && !groups_.empty() && !stopping(); ++d)
            if (working_[d])
                devices.push_back(d);
        return devices;
    }

    bool has_work_for(std::size_t device) {
        const std::lock_guard<std::mutex> lock(mutex_);
        return next_pays(device);
    }

    // Fits at once of a device.
    std::size_t at_once(std::size_t device) const {
        const std::size_t part = std::max<std::size_t>(devices_[device].at_once / place_.jobs, 1);
        return std::min(place_.at_once > 0 ? place_.at_once : part, group_count_);
    }

    // Fits until nothing is left for the device.
    void work(std::size_t device, FileFitter& fitter) {
        try {
            for (Group group = take(device); !group.empty(); group = take(device))
                for (; !group.empty() && !stopping(); group.erase(group.begin()))
                    if (!fit(device, fitter, group.front())) {
                        give_back(std::move(group));
                        return;
                    }
        } catch (...) { // of the calls
            end(std::current_exception(), failure_);
        }
    }

    // A device cannot begin: the others do the work, unless the device is not to blame.
    void cannot_begin(std::size_t device, const std::exception_ptr& failure) {
        if (!leaves(device, failure))
            end(failure, hindrance_);
    }

    // Once all is done: throws what a call threw; returns what hindered the fits.
    std::exception_ptr result() const {
        if (failure_)
            std::rethrow_exception(failure_);
        return hindrance_;
    }

  private:
    double cost(const Group& group) const {
        double sum = 0;
        for (const std::size_t i : group)
            sum += cost_of(structures_[i], metric_);
        return sum;
    }

    bool stopping() const { return ended_ || (calls_.stop && calls_.stop()); }

    void end(const std::exception_ptr& failure, std::exception_ptr& kept) {
        const std::lock_guard<std::mutex> lock(mutex_);
        kept = failure;
        ended_ = true;
    }

    bool next_pays(std::size_t device) const {
        return working_[device] && !groups_.empty() &&
               devices_.pays(device, cost(groups_.front()), left_, working_, 0);
    }

    Group take(std::size_t device) {
        const std::lock_guard<std::mutex> lock(mutex_);
        if (stopping() || !next_pays(device))
            return {};
        Group group = std::move(groups_.front());
        groups_.pop_front();
        left_ -= cost(group);
        return group;
    }

    void give_back(Group group) {
        const std::lock_guard<std::mutex> lock(mutex_);
        left_ += cost(group);
        groups_.push_front(std::move(group));
    }

    // Whether a device is to blame for a failure and there are others, which then go on alone.
    bool leaves(std::size_t device, const std::exception_ptr& failure) {
        const std::string problem = failure_of_device(failure);
        const std::lock_guard<std::mutex> lock(mutex_);
        std::vector<bool> failed = failed_;
        failed[device] = true;
        if (problem.empty() || std::find(failed.begin(), failed.end(), false) == failed.end())
            return false;
        if (failed != failed_)
            spdlog::warn("device {} ({}): {}; others go on", devices_[device].device.index,
                         devices_[device].device.name, problem);
        failed_ = failed;
        working_[device] = false;
        if (place_.home == device)
            for (std::size_t d = 0; d < working_.size(); ++d)
                working_[d] = !failed[d];
        return true;
    }

    // Returns false where the device failed and another is to make the fit.
    bool fit(std::size_t device, FileFitter& fitter, std::size_t i) {
        ProgressFunction progress;
        if (calls_.next) {
            const std::lock_guard<std::mutex> lock(calling_);
            progress = calls_.next(i);
        }
        FitOutcome outcome{i, &devices_[device].device, std::nullopt, nullptr};
        try {
            outcome.result = fitter.fit(structures_[i], progress);
            devices_.took(device, cost({i}), outcome.result->seconds);
        } catch (const FitAbandoned&) {
            ended_ = true;
            return true;
        } catch (...) {
            outcome.failure = std::current_exception();
        }
        if (outcome.failure && leaves(device, outcome.failure))
            return false;
        const std::lock_guard<std::mutex> lock(calling_);
        calls_.done(std::move(outcome));
        return true;
    }

    FitDevices& devices_;
    const std::vector<Structure>& structures_;
    const Metric metric_;
    const FitPlace& place_;
    const FitCalls& calls_;
    std::mutex calling_; // of the calls
    std::mutex mutex_;   // of all below
    std::deque<Group> groups_;
    const std::size_t group_count_;
    double left_ = 0; // what the groups cost
    std::vector<bool> working_, failed_;
    std::exception_ptr failure_, hindrance_; // of the calls; of the fits
    std::atomic<bool> ended_{false};
};

FileFitter::FileFitter(const FileFitter& other, cl::CommandQueue queue)
    : device_(with_queue(other.device_, std::move(queue))), programs_(other.programs_),
      samples_(other.samples_), options_(other.options_), shared_(other.shared_),
      packed_(shared_->packed), thinned_(shared_->thinned) {}

void FileFitter::fit_from(FitQueue& queue, std::size_t device) {
    std::vector<std::thread> threads;
    try {
        for (std::size_t i = 1; i < queue.at_once(device); ++i)
            threads.emplace_back([&] {
                std::unique_ptr<FileFitter> fitter;
                try {
                    fitter.reset(
                        new FileFitter(*this, cl::CommandQueue(device_.context, device_.handle)));
                } catch (...) {
                    return queue.cannot_begin(device, std::current_exception());
                }
                queue.work(device, *fitter);
            });
    } catch (const std::system_error&) { // no more threads: those there do it all
    }
    queue.work(device, *this);
    for (std::thread& thread : threads)
        thread.join();
}

std::exception_ptr fit_all(FitDevices& devices, const Samples& samples, const FitOptions& options,
                           const std::vector<Structure>& structures, const FitPlace& place,
                           const FitCalls& calls) {
    FitQueue queue(devices, structures, options.metric, place, calls);
    if (place.packed != nullptr)
        place.packed->resize(devices.size());
    const auto work = [&](std::size_t device) {
        if (!queue.has_work_for(device)) // which costs a copy of the samples
            return;
        std::unique_ptr<FileFitter> fitter;
        try {
            const Device& on = devices[device].device;
            fitter = std::make_unique<FileFitter>(
                on, devices[device].programs, samples, options,
                packed_on(on, samples, options,
                          place.packed != nullptr ? &(*place.packed)[device] : nullptr));
        } catch (...) {
            return queue.cannot_begin(device, std::current_exception());
        }
        fitter->fit_from(queue, device);
    };
    // Again where a device left work behind for others that had ended.
    for (auto working = queue.working(); !working.empty(); working = queue.working()) {
        std::vector<std::thread> threads;
        for (std::size_t i = 1; i < working.size(); ++i)
            try {
                threads.emplace_back(work, working[i]);
            } catch (const std::system_error&) { // no more threads
                work(working[i]);
            }
        work(working[0]);
        for (std::thread& thread : threads)
            thread.join();
    }
    return queue.result();
}

} // namespace brdfit
