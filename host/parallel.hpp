#pragma once

#include "host/progress.hpp"

#include <algorithm>
#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace brdfit {

/// Calls body(begin, end) on pieces of [0, count) of at most `piece`, on all cores, or as many as
/// the system gives threads for. An exception from a piece is thrown again here, after all have
/// stopped.
template <typename Body>
void parallel_pieces(std::size_t count, std::size_t piece, Body body,
                     const ProgressFunction& progress = {}) {
    const std::size_t pieces = (count + piece - 1) / piece;
    const std::size_t workers =
        std::min<std::size_t>(std::max(1U, std::thread::hardware_concurrency()), pieces);
    std::atomic<std::size_t> next{0};
    std::exception_ptr failure;
    std::size_t done = 0;
    std::mutex mutex; // of both
    const auto work = [&] {
        try {
            for (std::size_t i = next++; i < pieces; i = next++) {
                body(i * piece, std::min(count, (i + 1) * piece));
                if (progress) {
                    const std::lock_guard<std::mutex> lock(mutex);
                    progress(static_cast<double>(++done) / static_cast<double>(pieces));
                }
            }
        } catch (...) {
            const std::lock_guard<std::mutex> lock(mutex);
            failure = std::current_exception();
            next = pieces;
        }
    };
    std::vector<std::thread> threads;
    threads.reserve(workers);
    try {
        for (std::size_t i = 1; i < workers; ++i)
            threads.emplace_back(work);
    } catch (const std::exception&) { // no more threads or memory: those there do it all
    }
    work();
    for (std::thread& thread : threads)
        thread.join();
    if (failure)
        std::rethrow_exception(failure);
}

} // namespace brdfit
