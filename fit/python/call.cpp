#include "fit/python/call.hpp"

#include "host/device/errors.hpp"
#include "host/error.hpp"

#include <map>
#include <memory>
#include <nanobind/stl/string.h>
#include <new>
#include <optional>
#include <regex>
#include <spdlog/sinks/base_sink.h>
#include <spdlog/spdlog.h>
#include <unistd.h>
#include <utility>

namespace brdfit::python {

namespace {

constexpr std::chrono::milliseconds between_looks{50};

// Of all below.
std::mutex devices_mutex;
pid_t user_of_devices = 0;

// Notes that this process uses OpenCL from now on.
void require_not_forked() {
    if (user_of_devices != 0 && user_of_devices != getpid())
        throw DeviceError(
            "this process was forked from one that uses OpenCL, whose threads it has not; expected "
            "a process started anew: multiprocessing.get_context(\"spawn\")");
    user_of_devices = getpid();
}

// Keeps what the library warns of until somebody takes it.
class Warnings : public spdlog::sinks::base_sink<std::mutex> {
  public:
    std::vector<std::string> take() {
        const std::lock_guard<std::mutex> lock(mutex_);
        return std::exchange(texts_, {});
    }

  private:
    void sink_it_(const spdlog::details::log_msg& message) override {
        if (message.level >= spdlog::level::warn)
            texts_.emplace_back(message.payload.data(), message.payload.size());
    }
    void flush_() override {}

    std::vector<std::string> texts_;
};

Warnings& warnings() {
    static const auto sink = std::make_shared<Warnings>();
    if (spdlog::default_logger()->name() != "brdfit")
        spdlog::set_default_logger(std::make_shared<spdlog::logger>("brdfit", sink));
    return *sink;
}

// The message with the names of Python's arguments in place of the command line's options.
std::string with_arguments(const std::string& message) {
    if (message.find("brdfit ") != std::string::npos) // of a command, as it is typed
        return message;
    static const std::regex option("(^|[ (])--([a-z]+)(?:-([a-z]+))?");
    std::string text;
    auto end = message.cbegin();
    for (std::sregex_iterator i(message.begin(), message.end(), option), last; i != last; ++i) {
        text.append(end, (*i)[1].second);
        text += (*i)[2] == "bound" ? "bounds" : (*i)[2].str();
        if ((*i)[3].matched)
            text += "_" + (*i)[3].str();
        end = (*i)[0].second;
    }
    return text.append(end, message.cend());
}

// Until use_errors names those of the package.
PyObject* input_error = PyExc_ValueError;
PyObject* device_error = PyExc_RuntimeError;

void translate(const std::exception_ptr& pointer, void*) {
    try {
        std::rethrow_exception(pointer);
    } catch (const DeviceError& error) {
        PyErr_SetString(device_error, error.what());
    } catch (const cl::Error& error) {
        PyErr_SetString(device_error, message_of(error).c_str());
    } catch (const InputError& error) {
        PyErr_SetString(input_error, error.what());
    } catch (const UsageError& error) {
        PyErr_SetString(input_error, with_arguments(error.what()).c_str());
    } catch (const std::bad_alloc&) {
        PyErr_SetString(PyExc_MemoryError, "out of memory");
    } catch (const std::length_error&) { // of a vector longer than any memory
        PyErr_SetString(PyExc_MemoryError, "out of memory");
    }
}

} // namespace

const Device& opened(const std::string& wish) {
    const std::lock_guard<std::mutex> lock(devices_mutex);
    require_not_forked();
    // Not destroyed: when the process ends the driver may be gone first.
    static auto& devices = *new std::map<std::string, std::unique_ptr<const Device>>;
    std::unique_ptr<const Device>& device = devices[wish];
    try {
        if (!device)
            device = std::make_unique<const Device>(open_device(wish));
    } catch (const InputError& error) {
        throw DeviceError(error.what());
    }
    return *device;
}

std::vector<Device> known_devices() {
    const std::lock_guard<std::mutex> lock(devices_mutex);
    require_not_forked();
    try {
        return list_devices();
    } catch (const InputError& error) {
        throw DeviceError(error.what());
    }
}

void Call::say(double share, const std::string& what) {
    const std::lock_guard<std::mutex> lock(mutex_);
    share_ = share;
    what_ = what;
}

void watch(Call& call, const nb::object& progress,
           const std::function<bool(std::chrono::milliseconds)>& ended) {
    std::optional<nb::python_error> failure;
    const auto wait = [&] {
        const nb::gil_scoped_release released;
        return ended(between_looks);
    };
    for (bool over = false; !over;) {
        over = wait();
        if (failure)
            continue;
        try {
            // After the end too: a signal may have made the work fail, as compilers of drivers drop
            // their files then.
            if (PyErr_CheckSignals() != 0)
                throw nb::python_error();
            if (!progress.is_none() && !over) {
                std::string what;
                {
                    const std::lock_guard<std::mutex> lock(call.mutex_);
                    what = call.what_;
                }
                progress(call.share_.load(), what);
            }
        } catch (const nb::python_error& error) {
            failure.emplace(error);
            call.stopped_ = true;
        }
    }
    for (const std::string& text : warnings().take())
        if (!failure && PyErr_WarnEx(PyExc_UserWarning, text.c_str(), 1) != 0)
            failure.emplace();
    if (failure)
        throw std::move(*failure);
}

void collect_warnings() {
    warnings();
}

void translate_errors(nb::module_& module) {
    nb::register_exception_translator(translate);
    module.def(
        "use_errors",
        [](nb::handle input, nb::handle device) {
            input_error = input.inc_ref().ptr(); // as long as the process lives
            device_error = device.inc_ref().ptr();
        },
        nb::arg("input"), nb::arg("device"));
}

} // namespace brdfit::python
