#pragma once

#include "host/error.hpp"

#include <exception>
#include <string>

namespace brdfit {

/// Of one device, whatever the input: it is too small, or its driver fails.
struct DeviceError : InputError {
    using InputError::InputError;
};

/// The name of an OpenCL error code, "CL_OUT_OF_RESOURCES" for -5; of one that no header names its
/// number.
std::string opencl_error_name(int code);

/// What went wrong, for people: OpenCL's errors with the call that failed and their name, lack of
/// memory in words, everything else by its own message.
std::string message_of(const std::exception& error);
/// The same of one that was caught elsewhere.
std::string message_of(const std::exception_ptr& failure);

} // namespace brdfit
