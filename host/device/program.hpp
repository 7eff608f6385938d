#pragma once

#include "host/device/device.hpp"
#include "host/model/material.hpp"

#include <string>
#include <vector>

namespace brdfit {

/// What a program is specialised by: the models of a material, not their parameters.
struct Structure {
    const Model* diffuse = nullptr;
    std::vector<const Model*> lobes;
    bool isotropic = true; ///< form of every lobe

    /// For people and file names: "kurt" for any number of kurt lobes, "kurt+ward" for a mixture; a
    /// coupled diffuse shape stands for its lobe.
    std::string name() const;
    /// Whether a lobe's model reads a table (Model::table).
    bool has_tables() const;
    /// Unlike for structures that differ.
    std::string key() const;
};

/// A derivative a program computes: of basis function `basis` (0 diffuse, 1.. lobes) by parameter
/// `parameter` of the concatenated theta of all lobes.
struct DerivativeEntry {
    int basis, parameter;
};

/// How a structure's parameters, planes and derivatives are laid out in its program.
struct StructureLayout {
    std::vector<Parameter> parameters;    ///< of all lobes, concatenated
    std::vector<int> lobe_begin;          ///< first parameter of each lobe, then the count
    std::vector<DerivativeEntry> entries; ///< by lobe and parameter, then the diffuse shape's
    int basis = 1;                        ///< diffuse and lobes
    int planes = 0;                       ///< of the distinct models
};

StructureLayout layout_of(const Structure& structure);

/// Text of the kernel file (path below kernels/): from the folder that the environment variable
/// BRDFIT_KERNELS names, while developing, otherwise as built in.
/// Throws InputError for a file that is missing there.
std::string kernel_source(const std::string& path);

/// Builds the kernels evaluate.cl and, unless it has tables, fit.cl for a structure and files of
/// `channels` channels, handled `chunk` at once. Throws InputError with the build log, whose lines
/// carry the kernel file's name.
cl::Program build_program(const Device& device, const Structure& structure, int channels,
                          int chunk);

/// Builds sample.cl for a structure, which must have the anisotropic form. Throws like
/// build_program.
cl::Program build_sample_program(const Device& device, const Structure& structure);

/// Builds generator.cl, which reads tables of distributions.
cl::Program build_generator_program(const Device& device);

/// Builds albedo.cl for a structure, which must have the anisotropic form. Throws like
/// build_program.
cl::Program build_albedo_program(const Device& device, const Structure& structure);

/// Builds gram.cl, which knows no models.
cl::Program build_gram_program(const Device& device);
/// Builds peaks.cl, which measures what a device does at most.
cl::Program build_peaks_program(const Device& device);

/// Hash of the sources of all kernels, those used while developing included.
std::string kernel_hash();

} // namespace brdfit
