#pragma once

namespace brdfit {

/// A text file built into the program.
struct EmbeddedFile {
    const char* name; ///< path below its folder; null ends the list
    const char* text;
};

extern const EmbeddedFile embedded_kernels[]; ///< kernels/
extern const EmbeddedFile embedded_demo[];    ///< fit/cli/demo/: materials of the demo
extern const EmbeddedFile embedded_report[];  ///< fit/report/: parts of the page

} // namespace brdfit
