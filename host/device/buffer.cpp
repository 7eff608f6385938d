#include "host/device/buffer.hpp"

#include <cstdint>
#include <sys/mman.h>

namespace brdfit {

void prefer_large_pages(const Device& device, const cl::Buffer& buffer, std::size_t bytes) {
    constexpr std::uintptr_t page = 4096, large_page = 2 << 20;
    if (!device.cpu || bytes < large_page)
        return;
    void* const mapped =
        device.queue.enqueueMapBuffer(buffer, CL_TRUE, CL_MAP_WRITE_INVALIDATE_REGION, 0, bytes);
    const auto begin = (reinterpret_cast<std::uintptr_t>(mapped) + page - 1) / page * page;
    const auto end = (reinterpret_cast<std::uintptr_t>(mapped) + bytes) / page * page;
    // What a system without them answers changes nothing.
    madvise(reinterpret_cast<void*>(begin), end - begin, MADV_HUGEPAGE);
    device.queue.enqueueUnmapMemObject(buffer, mapped);
}

} // namespace brdfit
