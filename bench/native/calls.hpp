#pragma once

namespace brdfit::bench {

/// Calls of the functions whose throughput may bind, a sample.
struct Calls {
    double exp = 0, log = 0;
};

} // namespace brdfit::bench
