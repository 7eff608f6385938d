#include "host/device/tuning.hpp"
#include "tests/fuzz/fuzz.hpp"

#include <cstdlib>
#include <spdlog/sinks/null_sink.h>
#include <spdlog/spdlog.h>

using namespace brdfit;

// What brdfit tune keeps; broken files are ignored.
extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const Device device = [] {
        spdlog::set_default_logger(spdlog::null_logger_mt("none"));
        Device made;
        made.name = "device";
        made.platform = "platform";
        made.driver = "1";
        made.max_group = 1024;
        made.local_memory = 32768;
        return made;
    }();
    setenv("BRDFIT_TUNING", fuzz::input_file(data, size).c_str(), 1);
    if (const auto form = tuned_form(device))
        fuzz::require(is_possible(form->form, device), "a form that cannot run");
    return 0;
}
