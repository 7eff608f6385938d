// The part of FileFitter that fits many structures at once.
#include "fit/fit.hpp"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <system_error>
#include <thread>
#include <utility>

namespace brdfit {

namespace {

Device with_queue(Device device, cl::CommandQueue queue) {
    device.queue = std::move(queue);
    return device;
}

} // namespace

// One waits for the device while another is at work on the host.
std::size_t fits_at_once(const Device& device) {
    if (device.platform == "Oclgrind") // a simulator that takes calls of one thread alone
        return 1;
    return device.cpu ? std::max<std::size_t>(device.compute_units, 1) + 1 : 3;
}

FileFitter::FileFitter(const FileFitter& other, cl::CommandQueue queue)
    : device_(with_queue(other.device_, std::move(queue))), programs_(other.programs_),
      samples_(other.samples_), options_(other.options_), shared_(other.shared_),
      packed_(shared_->packed), thinned_(shared_->thinned) {}

// Structures of the same models follow each other in one thread: they share planes, and those of
// more lobes wait for those of fewer.
void FileFitter::fit_all(const std::vector<Structure>& structures, std::size_t jobs,
                         const std::function<ProgressFunction(std::size_t index)>& next,
                         const std::function<void(FitOutcome)>& done,
                         const std::function<bool()>& stop) {
    std::vector<std::vector<std::size_t>> groups;
    for (std::size_t i = 0; i < structures.size(); ++i) {
        const auto known = std::find_if(groups.begin(), groups.end(), [&](const auto& group) {
            return same_planes(structures[group.front()], structures[i]);
        });
        if (known != groups.end())
            known->push_back(i);
        else
            groups.push_back({i});
    }
    std::atomic<std::size_t> next_group{0};
    std::atomic<bool> failed{false};
    std::exception_ptr failure;
    std::mutex mutex; // of the calls and of the failure
    const auto fit_one = [&](FileFitter& fitter, std::size_t i) {
        ProgressFunction progress;
        if (next) {
            const std::lock_guard<std::mutex> lock(mutex);
            progress = next(i);
        }
        FitOutcome outcome{i, std::nullopt, nullptr};
        try {
            outcome.result = fitter.fit(structures[i], progress);
        } catch (...) {
            outcome.failure = std::current_exception();
        }
        const std::lock_guard<std::mutex> lock(mutex);
        done(std::move(outcome));
    };
    const auto work = [&](FileFitter& fitter) {
        for (std::size_t g = next_group++; g < groups.size(); g = next_group++)
            for (const std::size_t i : groups[g]) {
                if (failed || (stop && stop()))
                    return;
                fit_one(fitter, i);
            }
    };
    const auto guarded = [&](const auto& body) {
        try {
            body();
        } catch (...) {
            const std::lock_guard<std::mutex> lock(mutex);
            failure = std::current_exception();
            failed = true;
        }
    };
    std::vector<std::thread> threads;
    try {
        for (std::size_t i = 1; i < std::min(jobs, groups.size()); ++i)
            threads.emplace_back([&] {
                guarded([&] {
                    FileFitter fitter(*this, cl::CommandQueue(device_.context, device_.handle));
                    work(fitter);
                });
            });
    } catch (const std::system_error&) { // no more threads: those there do it all
    }
    guarded([&] { work(*this); });
    for (std::thread& thread : threads)
        thread.join();
    if (failure)
        std::rethrow_exception(failure);
}

} // namespace brdfit
