// Stands between a program and its OpenCL driver (LD_PRELOAD) and makes that a bad one:
//   FAULTY_DEVICE=N       only the platform's device of that index; otherwise all
//   FAULTY_PLATFORM=NAME  what the platform calls itself
//   FAULTY_BUILD=1        crashes while it builds a program
//   FAULTY_BINARIES=1     has no binaries of its programs
//   FAULTY_BUFFERS=N      has memory for N buffers
//   FAULTY_KERNELS=N      runs N kernels, and then none

#define CL_TARGET_OPENCL_VERSION 120
#include <CL/cl.h>
#include <algorithm>
#include <atomic>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <dlfcn.h>

namespace {

// The function that this library stands before.
template <typename Function>
Function* real(Function*, const char* name) {
    return reinterpret_cast<Function*>(dlsym(RTLD_NEXT, name));
}
#define REAL(function) real(function, #function)

bool is_faulty(cl_device_id device) {
    const char* const index = std::getenv("FAULTY_DEVICE");
    if (index == nullptr)
        return true;
    cl_platform_id platform = nullptr;
    cl_device_id devices[16] = {};
    REAL(clGetDeviceInfo)(device, CL_DEVICE_PLATFORM, sizeof platform, &platform, nullptr);
    REAL(clGetDeviceIDs)(platform, CL_DEVICE_TYPE_ALL, 16, devices, nullptr);
    return devices[std::atoi(index) % 16] == device;
}

// Whether a call is one more than the variable grants.
bool is_too_much(const char* variable, std::atomic<int>& calls) {
    const char* const most = std::getenv(variable);
    return most != nullptr && calls++ >= std::atoi(most);
}

} // namespace

extern "C" {

cl_int clGetPlatformInfo(cl_platform_id platform, cl_platform_info what, size_t size, void* value,
                         size_t* needed) {
    const char* const name = std::getenv("FAULTY_PLATFORM");
    if (what != CL_PLATFORM_NAME || name == nullptr)
        return REAL(clGetPlatformInfo)(platform, what, size, value, needed);
    const std::size_t length = std::strlen(name) + 1;
    if (needed != nullptr)
        *needed = length;
    if (value != nullptr)
        std::memcpy(value, name, std::min(size, length));
    return CL_SUCCESS;
}

cl_int clBuildProgram(cl_program program, cl_uint count, const cl_device_id* devices,
                      const char* options, void(CL_CALLBACK* notify)(cl_program, void*),
                      void* data) {
    if (std::getenv("FAULTY_BUILD") != nullptr && count > 0 && is_faulty(devices[0]))
        std::raise(SIGSEGV);
    return REAL(clBuildProgram)(program, count, devices, options, notify, data);
}

cl_int clGetProgramInfo(cl_program program, cl_program_info what, size_t size, void* value,
                        size_t* needed) {
    const bool none = std::getenv("FAULTY_BINARIES") != nullptr && value != nullptr;
    if (none && what == CL_PROGRAM_BINARIES)
        return CL_SUCCESS;
    const cl_int error = REAL(clGetProgramInfo)(program, what, size, value, needed);
    if (none && what == CL_PROGRAM_BINARY_SIZES)
        std::memset(value, 0, size);
    return error;
}

cl_mem clCreateBuffer(cl_context context, cl_mem_flags flags, size_t size, void* host,
                      cl_int* error) {
    static std::atomic<int> calls{0};
    cl_device_id device = nullptr;
    REAL(clGetContextInfo)(context, CL_CONTEXT_DEVICES, sizeof device, &device, nullptr);
    if (!is_faulty(device) || !is_too_much("FAULTY_BUFFERS", calls))
        return REAL(clCreateBuffer)(context, flags, size, host, error);
    if (error != nullptr)
        *error = CL_MEM_OBJECT_ALLOCATION_FAILURE;
    return nullptr;
}

cl_int clEnqueueNDRangeKernel(cl_command_queue queue, cl_kernel kernel, cl_uint dimensions,
                              const size_t* offset, const size_t* global, const size_t* local,
                              cl_uint count, const cl_event* events, cl_event* event) {
    static std::atomic<int> calls{0};
    cl_device_id device = nullptr;
    REAL(clGetCommandQueueInfo)(queue, CL_QUEUE_DEVICE, sizeof device, &device, nullptr);
    if (is_faulty(device) && is_too_much("FAULTY_KERNELS", calls))
        return CL_OUT_OF_RESOURCES;
    return REAL(clEnqueueNDRangeKernel)(queue, kernel, dimensions, offset, global, local, count,
                                        events, event);
}
}
